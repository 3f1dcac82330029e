#include "world/robot/kinematics/choice/make_inverse_kinematics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string>

#include "world/robot/kinematics/choice/other_fits.hpp"
#include "world/robot/kinematics/choice/six_axis_fits.hpp"
#include "world/robot/kinematics/families/spherical_wrist_ik.hpp"
#include "world/robot/kinematics/families/srs_ik.hpp"
#include "world/robot/kinematics/numeric/numeric_ik.hpp"

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

/// The axis signs, where every joint is as the pattern has it.
std::optional<JointVector> match(const ArmModel& model, std::span<const JointPattern> patterns) {
  if (model.X_LF || model.joints.size() != patterns.size()) return std::nullopt;
  JointVector sign(model.dof());
  for (std::size_t i = 0; i < patterns.size(); ++i) {
    const Joint& joint = model.joints[i];
    if (joint.prismatic || !fits(joint, patterns[i])) return std::nullopt;
    sign(static_cast<Eigen::Index>(i)) = joint.axis(patterns[i].axis) > 0 ? 1 : -1;
  }
  return sign;
}

/// Six axes with a spherical wrist: the lengths from the joints' offsets at zero.
std::unique_ptr<InverseKinematics> make_spherical_wrist(const ArmModel& model) {
  auto sign = match(model, kSphericalWrist);
  if (!sign) return nullptr;
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
  if (!(geometry.upper > kFits && geometry.fore_x > kFits)) return nullptr;
  return std::make_unique<SphericalWristIk>(model, std::move(geometry));
}

/// Seven axes, spherical shoulder, revolute elbow, spherical wrist.
std::unique_ptr<InverseKinematics> make_srs(const ArmModel& model) {
  auto sign = match(model, kSrs);
  if (!sign) return nullptr;
  const auto along = [&](std::size_t joint) { return model.joints[joint].X_PJ.translation().z(); };
  // S-R-S arm: both shoulder axes and both wrist axes meet, which leaves one redundant degree of
  // freedom, the elbow angle.
  SrsGeometry geometry{.shoulder_z = along(0) + along(1),
                       .upper = along(2) + along(3),
                       .fore = along(4) + along(5),
                       .flange_z = along(6),
                       .sign = *sign};
  if (!(geometry.upper > kFits && geometry.fore > kFits)) return nullptr;
  return std::make_unique<SrsIk>(model, std::move(geometry));
}

}  // namespace

Result<std::unique_ptr<InverseKinematics>> make_inverse_kinematics(const ArmModel& model) {
  if (model.dof() < kMinDof || model.dof() > kMaxDof) {
    return fail(ErrorCode::kUnimplemented, "joints",
                "\"" + model.name + "\" has " + std::to_string(model.dof()) + " joints, expected " +
                    std::to_string(kMinDof) + " to " + std::to_string(kMaxDof));
  }
  const bool turns = std::none_of(model.joints.begin(), model.joints.end(),
                                  [](const Joint& joint) { return joint.prismatic; });
  std::unique_ptr<InverseKinematics> found;
  if (turns && model.dof() == 6) {
    found = make_spherical_wrist(model);
    if (!found) found = fit_spherical_wrist(model);
    if (!found) found = fit_offset_wrist(model);
  } else if (turns && model.dof() == 7) {
    found = make_srs(model);
    if (!found) found = fit_seven_axes(model);
  } else if (model.dof() == 4) {
    found = fit_scara(model);
  }
  if (!found) found = std::make_unique<NumericIk>(model);
  return found;
}

}  // namespace aprsim::robot
