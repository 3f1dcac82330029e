#include "world/robot/kinematics/inverse_kinematics.hpp"

#include <array>
#include <cmath>
#include <span>
#include <sstream>

#include "world/robot/kinematics/spherical_wrist_ik.hpp"
#include "world/robot/kinematics/srs_ik.hpp"

namespace aprsim::robot {
namespace {

constexpr double kFits = 1e-9;  ///< tolerated in offsets [m] and axis components
constexpr int kX = 0, kY = 1, kZ = 2;

/// Requirements of a family on one joint at its zero position: frames parallel to the base, the
/// axis along one base axis (either way), and an offset along the marked base axes only.
struct JointPattern {
  int axis;
  std::array<bool, 3> offset;
};

// Pieper 1968: an arm has a closed form if three consecutive axes meet in a point, here those of
// the wrist. The pattern also requires the axes to be parallel or orthogonal at zero, which makes
// the arm's part planar.
constexpr std::array<JointPattern, 6> kSphericalWrist{{{kZ, {false, false, true}},
                                                       {kY, {true, false, true}},
                                                       {kY, {false, false, true}},
                                                       {kX, {true, false, true}},
                                                       {kY, {true, false, false}},
                                                       {kX, {true, false, false}}}};
constexpr JointPattern kSrsRoll{kZ, {false, false, true}}, kSrsPitch{kY, {false, false, true}};
constexpr std::array<JointPattern, 7> kSrs{
    {kSrsRoll, kSrsPitch, kSrsRoll, kSrsPitch, kSrsRoll, kSrsPitch, kSrsRoll}};

bool fits(const Joint& joint, const JointPattern& pattern) {
  if ((joint.X_PJ.linear() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > kFits) {
    return false;
  }
  for (int i = 0; i < 3; ++i) {
    // Signs of axes differ between makers. They are absorbed by q = sign t, so that one set of
    // formulas serves all.
    const double axis = std::abs(joint.axis(i)) - (i == pattern.axis ? 1 : 0);
    if (std::abs(axis) > kFits) return false;
    const bool free = pattern.offset[static_cast<std::size_t>(i)];
    if (!free && std::abs(joint.X_PJ.translation()(i)) > kFits) return false;
  }
  return true;
}

/// Checks every joint and returns the axis signs.
Result<JointVector> match(const ArmModel& model, std::span<const JointPattern> patterns) {
  constexpr std::array<char, 3> kNames{'x', 'y', 'z'};
  JointVector sign(model.dof());
  for (std::size_t i = 0; i < patterns.size(); ++i) {
    const Joint& joint = model.joints[i];
    // The error lists what the joint has and what the family requires.
    if (!fits(joint, patterns[i])) {
      std::ostringstream text;
      text << "no closed form fits \"" << model.name << "\": joint \"" << joint.name
           << "\" needs an axis along +-" << kNames[static_cast<std::size_t>(patterns[i].axis)]
           << ", no rotation at zero and an offset along";
      for (std::size_t k = 0; k < 3; ++k) {
        if (patterns[i].offset[k]) text << " " << kNames[k];
      }
      text << " only; it has axis (" << joint.axis.transpose() << ") and offset ("
           << joint.X_PJ.translation().transpose() << ") m";
      return fail(ErrorCode::kUnimplemented, joint.name, text.str());
    }
    sign(static_cast<Eigen::Index>(i)) = joint.axis(patterns[i].axis) > 0 ? 1 : -1;
  }
  return sign;
}

/// Refuses arms without upper arm or forearm.
Result<void> need_positive(const ArmModel& model, std::initializer_list<double> lengths) {
  for (const double length : lengths) {
    if (!(length > kFits)) {
      return fail(ErrorCode::kUnimplemented, "geometry",
                  "no closed form fits \"" + model.name +
                      "\": upper arm and forearm need a positive length");
    }
  }
  return {};
}

/// Six axes with a spherical wrist: the lengths from the joints' offsets at zero.
Result<std::unique_ptr<InverseKinematics>> make_spherical_wrist(const ArmModel& model) {
  auto sign = match(model, kSphericalWrist);
  if (!sign) return tl::unexpected(sign.error());
  const auto offset = [&](std::size_t joint) {
    return Eigen::Vector3d(model.joints[joint].X_PJ.translation());
  };
  // Offsets along an axis can be added up, since rotation about it leaves them unchanged.
  SphericalWristGeometry geometry{.shoulder_z = offset(0).z() + offset(1).z(),
                                  .shoulder_x = offset(1).x(),
                                  .upper = offset(2).z(),
                                  .elbow_z = offset(3).z(),
                                  .fore_x = offset(3).x() + offset(4).x(),
                                  .flange_x = offset(5).x(),
                                  .sign = *sign};
  if (auto ok = need_positive(model, {geometry.upper, geometry.fore_x}); !ok) {
    return tl::unexpected(ok.error());
  }
  return std::make_unique<SphericalWristIk>(model, std::move(geometry));
}

/// Seven axes, spherical shoulder, revolute elbow, spherical wrist.
Result<std::unique_ptr<InverseKinematics>> make_srs(const ArmModel& model) {
  auto sign = match(model, kSrs);
  if (!sign) return tl::unexpected(sign.error());
  const auto along = [&](std::size_t joint) { return model.joints[joint].X_PJ.translation().z(); };
  // S-R-S arm: both shoulder axes and both wrist axes meet, which leaves one redundant degree of
  // freedom, the elbow angle.
  SrsGeometry geometry{.shoulder_z = along(0) + along(1),
                       .upper = along(2) + along(3),
                       .fore = along(4) + along(5),
                       .flange_z = along(6),
                       .sign = *sign};
  if (auto ok = need_positive(model, {geometry.upper, geometry.fore}); !ok) {
    return tl::unexpected(ok.error());
  }
  return std::make_unique<SrsIk>(model, std::move(geometry));
}

}  // namespace

Result<std::unique_ptr<InverseKinematics>> make_inverse_kinematics(const ArmModel& model) {
  if (model.dof() == 6) return make_spherical_wrist(model);
  if (model.dof() == 7) return make_srs(model);
  return fail(ErrorCode::kUnimplemented, "joints",
              "no closed form for an arm of " + std::to_string(model.dof()) +
                  " joints; supported are 6 (spherical wrist) and 7 (S-R-S)");
}

}  // namespace aprsim::robot
