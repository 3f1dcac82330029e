#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "crcl/commands.hpp"
#include "crcl/units.hpp"
#include "world/api/values/wire_joint.hpp"

namespace aprsim::crcl_server {

/// Settings of one connection: its units and the content of its statuses. They change only through
/// the commands of that connection; InitCanon leaves it alone.
class ConnectionSettings {
 public:
  /// Every joint's position, the pose and the settings are reported; not the gripper.
  ConnectionSettings(crcl::Units units, bool joints_in_degrees)
      : units_(units), joints_in_degrees_(joints_in_degrees) {}

  void apply(const crcl::SetUnits& set) {
    std::visit([this](auto unit) { store(unit); }, set.unit);
  }
  void apply(const crcl::ConfigureStatusReport& command) {
    sections_ = command;
    configured_ = true;
  }
  /// ResetAll turns every joint off before the listed ones are set; other joints stay as they are.
  void apply(const crcl::ConfigureJointReports& command) {
    if (command.reset_all) {
      listed_.clear();
      unlisted_positions_ = false;
    }
    for (const crcl::JointReport& report : command.reports) {
      if (report.joint < 1 || report.joint > static_cast<int>(api::kMaxWireJoints)) {
        continue;  // no robot has it
      }
      std::erase_if(listed_, [&](const auto& known) { return known.joint == report.joint; });
      listed_.push_back(report);
    }
  }

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
  [[nodiscard]] crcl::JointReport joint(int number) const {
    const auto known = std::ranges::find(listed_, number, &crcl::JointReport::joint);
    if (known != listed_.end()) return *known;
    return {number, unlisted_positions_, false, false};
  }

 private:
  void store(crcl::LengthUnit unit) { units_.length = unit; }
  void store(crcl::AngleUnit unit) { units_.angle = unit; }
  void store(crcl::ForceUnit unit) { units_.force = unit; }
  void store(crcl::TorqueUnit unit) { units_.torque = unit; }

  crcl::Units units_;
  bool joints_in_degrees_;
  crcl::ConfigureStatusReport sections_{true, true, false, true, false, false};
  bool configured_ = false;
  bool unlisted_positions_ = true;         // joints that no command has named
  std::vector<crcl::JointReport> listed_;  // each joint at most once
};

/// The sender of a command.
struct Caller {
  std::shared_ptr<ConnectionSettings> settings;  ///< of its connection; a program outlives that
  std::string peer;                              ///< address and port
};

}  // namespace aprsim::crcl_server
