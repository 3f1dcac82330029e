#pragma once

#include <vector>

#include "crcl/commands.hpp"
#include "crcl/units.hpp"

namespace aprsim::protocols {

/// What one connection has chosen for itself: its units and what its statuses contain. Changes only
/// through the commands of that connection; InitCanon leaves it alone.
class ConnectionSettings {
 public:
  /// Every joint's position, the pose and the settings are reported; not the gripper.
  ConnectionSettings(crcl::Units units, bool joints_in_degrees)
      : units_(units), joints_in_degrees_(joints_in_degrees) {}

  void apply(const crcl::SetUnits& set);
  void apply(const crcl::ConfigureStatusReport& command) {
    sections_ = command;
    configured_ = true;
  }
  /// ResetAll turns every joint off before the listed ones are set; other joints stay as they are.
  void apply(const crcl::ConfigureJointReports& command);

  void report_gripper(bool on) { sections_.gripper = on; }

  [[nodiscard]] const crcl::Units& units() const { return units_; }
  [[nodiscard]] crcl::AngleUnit joint_unit() const {
    return joints_in_degrees_ ? crcl::AngleUnit::kDegree : units_.angle;
  }
  [[nodiscard]] const crcl::ConfigureStatusReport& sections() const { return sections_; }
  /// Guards show by themselves once there are any, until a ConfigureStatusReport decides.
  [[nodiscard]] bool wants_guards(bool any) const {
    return sections_.guards || (!configured_ && any);
  }
  /// For the joint with that 1-based number.
  [[nodiscard]] crcl::JointReport joint(int number) const;

 private:
  crcl::Units units_;
  bool joints_in_degrees_;
  crcl::ConfigureStatusReport sections_{true, true, false, true, false, false};
  bool configured_ = false;
  bool unlisted_positions_ = true;         // joints that no command has named
  std::vector<crcl::JointReport> listed_;  // each joint at most once
};

}  // namespace aprsim::protocols
