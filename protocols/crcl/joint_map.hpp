#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "crcl/units.hpp"
#include "world/api/commands/motion_command.hpp"
#include "world/api/description/cell_description.hpp"
#include "world/api/values/wire_joint.hpp"

namespace aprsim::crcl_server {

/// Target of one joint as CRCL counts it; angles [rad] are those of its own counting.
struct WireTarget {
  int number = 1;  ///< 1-based, within the map
  double angle_rad = 0;
  std::optional<double> speed_rad_s{}, accel_rad_s2{};
  std::optional<api::JointTorque> torque{};
  std::optional<double> tolerance_rad{};
};

/// Between a robot's joints as CRCL counts them and the arm's own: the angles of the wire's joints
/// are a linear function of the arm's, and back. Torques are those of the drives, with the sense of
/// their joint. Numbers are 1-based, within 1 to count(). Immutable. Thread: any.
class JointMap {
 public:
  /// Throws std::invalid_argument where the description's wire joints do not give every joint of
  /// the arm exactly once, or cannot be solved for each other.
  explicit JointMap(const api::RobotDescription& robot);

  [[nodiscard]] int count() const { return static_cast<int>(wire_.size()); }
  /// The arm's joint, 0-based; -1 for a number that none has.
  [[nodiscard]] int arm_joint(int number) const { return at(number).joint; }
  /// The number of the arm's joint, 0-based.
  [[nodiscard]] int number_of(int arm_joint) const;
  /// 1, or -1 where the joint turns the other way.
  [[nodiscard]] double sign(int number) const { return at(number).sign; }

  // Values on the wire, and rates of them, in the joint's unit: counts of the drive, millimetres of
  // a prismatic joint, else `unit`.

  [[nodiscard]] double to_rad(int number, double value, crcl::AngleUnit unit) const;
  [[nodiscard]] double from_rad(int number, double rad, crcl::AngleUnit unit) const;
  /// As from_rad(), with the digits that carry meaning.
  [[nodiscard]] double reported(int number, double rad, crcl::AngleUnit unit) const;
  /// "degree", "pulse", "millimeter".
  [[nodiscard]] std::string_view unit_name(int number, crcl::AngleUnit unit) const;

  /// The joint's highest speed, where it is counted in pulses: JointSpeed is then in percent of it.
  [[nodiscard]] std::optional<double> full_speed_rad_s(int number) const {
    const api::WireJoint& joint = at(number);
    if (joint.counts_per_rad == 0 || joint.joint < 0) return std::nullopt;
    return arm_[static_cast<std::size_t>(joint.joint)].max_speed_rad_s;
  }

  // Angles of the wire's joints [rad]; rates without offsets.

  [[nodiscard]] Eigen::VectorXd wire_angles(const Eigen::VectorXd& arm_rad) const;
  [[nodiscard]] Eigen::VectorXd wire_rates(const Eigen::VectorXd& arm_rad_s) const;
  [[nodiscard]] Eigen::VectorXd arm_angles(const Eigen::VectorXd& wire_rad) const;

  /// Range of the wire's joint [rad]: as the scene says, else as the arm's limits leave it when no
  /// other joint stands in the way.
  [[nodiscard]] api::AngleRange range(int number) const;
  /// Whether the range is the scene's, to be kept beside the arm's limits.
  [[nodiscard]] bool own_range(int number) const { return at(number).has_range(); }

  /// The same as targets of the arm's joints. Wire joints that are not named stay where they are
  /// held; those that no joint has are left out. Speeds and accelerations of the joints that move
  /// one of the arm's add up. Each number at most once.
  [[nodiscard]] api::MoveJoints to_move(const std::vector<WireTarget>& targets) const;

  /// `text` with the numbers of the arm's joints that it names, and their ranges where the wire has
  /// another unit.
  [[nodiscard]] std::string explained(std::string text) const;

 private:
  [[nodiscard]] const api::WireJoint& at(int number) const {
    return wire_[static_cast<std::size_t>(number - 1)];
  }
  [[nodiscard]] bool slides(int number) const {
    const int joint = arm_joint(number);
    return joint >= 0 && arm_[static_cast<std::size_t>(joint)].prismatic;
  }
  [[nodiscard]] std::string explanation(int arm_joint) const;

  std::vector<api::WireJoint> wire_;
  std::vector<api::JointDescription> arm_;
  Eigen::MatrixXd to_arm_;   // arm = to_arm * wire + offset; a column each wire joint
  Eigen::MatrixXd to_wire_;  // rows of joints that the arm does not have are 0
  Eigen::VectorXd offset_;
};

}  // namespace aprsim::crcl_server
