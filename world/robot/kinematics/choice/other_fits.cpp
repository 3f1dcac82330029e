#include "world/robot/kinematics/choice/other_fits.hpp"

#include <array>
#include <cmath>

#include "world/robot/kinematics/choice/axis_lines.hpp"
#include "world/robot/kinematics/families/offset_elbow_ik.hpp"
#include "world/robot/kinematics/families/scara_ik.hpp"
#include "world/robot/kinematics/families/srs_ik.hpp"
#include "world/robot/model/joint_rotation.hpp"

namespace aprsim::robot {
namespace {

using Eigen::Vector3d;

const Vector3d kAlongX = Vector3d::UnitX(), kAlongY = Vector3d::UnitY(),
               kAlongZ = Vector3d::UnitZ();

/// Angles at zero of axes that turn about z and y by turns, and their senses.
class AlternatingAxes {
 public:
  AlternatingAxes(const Vector3d& z, const Vector3d& y) { R_ << y.cross(z), y, z; }

  /// Turns about y so that z points along `axis`, or against it where `reversed`.
  void pitch_to(const Vector3d& axis, bool reversed) {
    const double sign = reversed ? -1 : 1;
    const Vector3d w = sign * (R_.transpose() * axis);
    add(kAlongY, std::atan2(w.x(), w.z()), sign);
  }
  /// Turns about z so that y points along `axis`.
  void roll_to(const Vector3d& axis) {
    const Vector3d w = R_.transpose() * axis;
    add(kAlongZ, std::atan2(-w.x(), w.y()), 1);
  }
  [[nodiscard]] const Eigen::Matrix3d& rotation() const { return R_; }
  [[nodiscard]] double zero(std::size_t turn) const { return zero_[turn]; }
  /// Sense of the axis that the turn has led to.
  [[nodiscard]] double sense(std::size_t turn) const { return sense_[turn]; }

 private:
  void add(const Vector3d& about, double angle, double sense) {
    rotate_by(R_, about, angle);
    zero_.push_back(angle);
    sense_.push_back(sense);
  }

  Eigen::Matrix3d R_;
  std::vector<double> zero_, sense_;
};

/// Point of a line nearest to another point.
Vector3d nearest_on(const AxisLine& line, const Vector3d& point) {
  return line.point + line.direction * line.direction.dot(point - line.point);
}

}  // namespace

std::unique_ptr<InverseKinematics> fit_seven_axes(const ArmModel& model) {
  const std::vector<AxisLine> lines = axis_lines(model);
  const auto shoulder = meeting_point({lines[0], lines[1], lines[2]});
  const auto wrist = meeting_point({lines[4], lines[5]});
  if (!shoulder || !wrist) return nullptr;
  for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
    if (!are_orthogonal(lines[i], lines[i + 1])) return nullptr;
  }
  // Axis 4 at the height of the shoulder; axes 3 and 5 point from the shoulder to the wrist.
  const Vector3d elbow = nearest_on(lines[3], *shoulder);
  const bool reversed_3 = lines[2].direction.dot(elbow - *shoulder) < 0;
  const bool reversed_5 = lines[4].direction.dot(*wrist - elbow) < 0;
  AlternatingAxes axes(lines[0].direction, lines[1].direction);
  Eigen::Isometry3d X_BA = Eigen::Isometry3d::Identity();
  X_BA.linear() = axes.rotation();
  X_BA.translation() = *shoulder;
  axes.pitch_to(lines[2].direction, reversed_3);
  axes.roll_to(lines[3].direction);
  const Vector3d upper = axes.rotation().transpose() * (elbow - *shoulder);
  axes.pitch_to(lines[4].direction, reversed_5);
  const Vector3d fore = axes.rotation().transpose() * (*wrist - elbow);
  axes.roll_to(lines[5].direction);
  axes.pitch_to(lines[6].direction, false);
  const Vector3d last = axes.rotation().transpose() * (nearest_on(lines[6], *wrist) - *wrist);

  const OffsetElbowGeometry geometry{upper.x(), upper.z(), fore.x(), fore.z(), last.x()};
  CanonicalArm canonical;
  canonical.add(kAlongZ, Vector3d::Zero(), 1, 0);
  canonical.add(kAlongY, Vector3d::Zero(), 1, axes.zero(0));
  canonical.add(kAlongZ, Vector3d::Zero(), axes.sense(0), axes.zero(1));
  canonical.add(kAlongY, {geometry.elbow_x, 0, geometry.upper}, 1, axes.zero(2));
  canonical.add(kAlongZ, {geometry.fore_x, 0, geometry.fore}, axes.sense(2), axes.zero(3));
  canonical.add(kAlongY, Vector3d::Zero(), 1, axes.zero(4));
  canonical.add(kAlongZ, {geometry.wrist_x, 0, 0}, 1, 0);
  auto placement = canonical.match(model, X_BA);
  if (!placement || std::hypot(geometry.elbow_x, geometry.upper) < kLineTolerance ||
      std::hypot(geometry.fore_x, geometry.fore) < kLineTolerance) {
    return nullptr;
  }
  const bool is_srs = std::abs(geometry.elbow_x) < kLineTolerance &&
                      std::abs(geometry.fore_x) < kLineTolerance &&
                      std::abs(geometry.wrist_x) < kLineTolerance;
  std::unique_ptr<const BranchedIk> family;
  if (is_srs) {
    family = std::make_unique<SrsIk>(
        model, SrsGeometry{0, geometry.upper, geometry.fore, 0, JointVector::Ones(7)});
  } else {
    family = std::make_unique<OffsetElbowIk>(model, geometry);
  }
  return std::make_unique<PlacedIk>(model, std::move(*placement), std::move(family));
}

std::unique_ptr<InverseKinematics> fit_scara(const ArmModel& model) {
  const std::vector<AxisLine> lines = axis_lines(model);
  ScaraGeometry geometry{};
  std::size_t turning = 0;
  int sliding = 0;
  for (int i = 0; i < model.dof(); ++i) {
    if (!are_parallel(lines[0], lines[static_cast<std::size_t>(i)])) return nullptr;
    if (model.joints[static_cast<std::size_t>(i)].prismatic) {
      geometry.sliding = i;
      ++sliding;
    } else if (turning < 3) {
      geometry.turning[turning++] = i;
    }
  }
  if (turning != 3 || sliding != 1) return nullptr;
  const auto line = [&](std::size_t i) {
    return lines[static_cast<std::size_t>(geometry.turning[i])];
  };
  const auto [first, second, third] = std::array{line(0), line(1), line(2)};
  const Vector3d z = first.direction;
  const auto flat = [&z](const Vector3d& v) { return Vector3d(v - z * z.dot(v)); };
  const Vector3d upper = flat(second.point - first.point), fore = flat(third.point - second.point);
  if (upper.norm() < kLineTolerance || fore.norm() < kLineTolerance) return nullptr;
  Eigen::Isometry3d X_BA = Eigen::Isometry3d::Identity();
  X_BA.linear() << upper.normalized(), z.cross(upper.normalized()), z;
  X_BA.translation() = first.point;
  const Vector3d fore_A = X_BA.linear().transpose() * fore;
  geometry.upper = upper.norm();
  geometry.fore = fore.norm();

  CanonicalArm canonical;
  const std::array<double, 3> length{0, geometry.upper, geometry.fore};
  const std::array<double, 3> zero{0, std::atan2(fore_A.y(), fore_A.x()), 0};
  turning = 0;
  for (int i = 0; i < model.dof(); ++i) {
    const double sign = lines[static_cast<std::size_t>(i)].direction.dot(z) > 0 ? 1 : -1;
    if (i == geometry.sliding) {
      canonical.add(kAlongZ, Vector3d::Zero(), sign, 0, true);
    } else {
      canonical.add(kAlongZ, length[turning] * kAlongX, sign, zero[turning]);
      ++turning;
    }
  }
  auto placement = canonical.match(model, X_BA);
  if (!placement) return nullptr;
  return std::make_unique<PlacedIk>(model, std::move(*placement),
                                    std::make_unique<ScaraIk>(model, geometry));
}

}  // namespace aprsim::robot
