#pragma once

#include <array>
#include <optional>
#include <string>

#include "world/api/snapshot/robot_snapshot.hpp"
#include "world/api/values/pose.hpp"
#include "world/physics/gripper/gripper_wear.hpp"

namespace aprsim::world {

/// Effects of injected faults on one robot; the defaults have no effect.
struct RobotFaults {
  RobotFaults() { torque.fill(1); }

  double speed = 1;                              ///< share of every motion's speed
  std::array<double, api::kMaxJoints> torque{};  ///< share of each joint's highest
  std::array<double, api::kMaxJoints> backlash_rad{}, encoder_bias_rad{};
  /// From where the tool is reported and commanded to where it is: in front, of the robot's frame;
  /// behind, of the tool's.
  Pose base_offset, tool_offset;
  double grip_force = 1;                  ///< share of what the pressure gives
  std::optional<double> gripper_setting;  ///< at which the gripper is stuck
  physics::GripperWear wear;
  /// Not empty: no command is carried out, and this is why.
  std::string out_of_order;
  bool brakes_on_path = false;  ///< when it goes out of order; else at once

  [[nodiscard]] bool has_offset() const {
    return !base_offset.p.isZero() || !tool_offset.p.isZero() ||
           !base_offset.q.isApprox(Eigen::Quaterniond::Identity(), 0);
  }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [speed, torque, backlash_rad, encoder_bias_rad, base_offset, tool_offset, grip_force,
           gripper_setting, wear, out_of_order, brakes_on_path] = self;
    io(speed, torque, backlash_rad, encoder_bias_rad, base_offset, tool_offset, grip_force,
       gripper_setting, wear, out_of_order, brakes_on_path);
  }
};

}  // namespace aprsim::world
