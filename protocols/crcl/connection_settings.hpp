#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "crcl/commands.hpp"
#include "crcl/units.hpp"
#include "world/api/values/wire_joint.hpp"

namespace aprsim::crcl_server {

/// Parts of a status that NIST's servers leave out. A connection gets one on request, by an
/// EnableRobotParameterStatus with its name: clients of NIST's read a status as one block of 4096
/// bytes.
enum class ExtraReport { kTwist, kWrench, kConfiguration, kLimits };
inline constexpr std::array<std::string_view, 4> kExtraReports{"twist", "wrench", "configuration",
                                                               "limits"};

/// Settings of one connection: its units and the content of its statuses. Only commands of that
/// connection change them; InitCanon does not.
class ConnectionSettings {
 public:
  /// Every joint's position, the pose and the settings are reported; not the gripper, and no
  /// ExtraReport.
  ConnectionSettings(crcl::Units units, bool joints_in_degrees)
      : units_(units), joints_in_degrees_(joints_in_degrees) {}

  void apply(const crcl::SetUnits& set) {
    std::visit([this](auto unit) { store(unit); }, set.unit);
  }
  void apply(const crcl::ConfigureStatusReport& command) { sections_ = command; }
  /// ResetAll turns off all joints before the listed ones are set; without it, others are kept.
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
  /// SetEndEffector is done once the gripper has settled; else as soon as the robot has it.
  void wait_for_end_effector() { waits_for_end_effector_ = true; }
  [[nodiscard]] bool waits_for_end_effector() const { return waits_for_end_effector_; }
  void report(ExtraReport part, bool on) { extras_[static_cast<std::size_t>(part)] = on; }
  void report_everything() { extras_.fill(true); }
  [[nodiscard]] bool reports(ExtraReport part) const {
    return extras_[static_cast<std::size_t>(part)];
  }

  [[nodiscard]] const crcl::Units& units() const { return units_; }
  [[nodiscard]] crcl::AngleUnit joint_unit() const {
    return joints_in_degrees_ ? crcl::AngleUnit::kDegree : units_.angle;
  }
  [[nodiscard]] const crcl::ConfigureStatusReport& sections() const { return sections_; }
  /// The report of the joint with that 1-based number.
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
  std::array<bool, kExtraReports.size()> extras_{};
  bool waits_for_end_effector_ = false;
  bool unlisted_positions_ = true;         // joints that no command has named
  std::vector<crcl::JointReport> listed_;  // each joint at most once
};

/// The sender of a command.
struct Caller {
  std::shared_ptr<ConnectionSettings> settings;  ///< of its connection; a program outlives that
  std::string peer;                              ///< address and port
};

}  // namespace aprsim::crcl_server
