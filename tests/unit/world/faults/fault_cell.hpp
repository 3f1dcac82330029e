#pragma once

#include <map>
#include <string>

#include "tests/support/cell_script.hpp"
#include "tests/support/pick_place.hpp"

namespace aprsim::test {

inline constexpr int kFanucArm = 0, kMotomanArm = 1;

/// The default cell, into which a test injects faults.
class FaultCell : public CellScript {
 public:
  FaultCell() : CellScript(load_scene("aprs")) {}

  /// Begins with the next step. Returns its number.
  std::uint64_t inject(const std::string& kind, const std::string& target = "",
                       std::map<std::string, double> parameters = {},
                       std::optional<SimTime> duration = {}, api::FaultTrigger trigger = {}) {
    const auto done =
        world.apply(++fault_ticket_, api::FaultCommand(api::InjectFault{
                                         kind, target, std::move(parameters), trigger, duration}));
    if (!done) throw std::runtime_error(done.error().message);
    world.write(now);
    return now.faults->all.back().id;
  }
  /// Ends it with the next step.
  void end(std::uint64_t id) {
    const auto done = world.apply(++fault_ticket_, api::FaultCommand(api::EndFault{id}));
    if (!done) throw std::runtime_error(done.error().message);
  }
  [[nodiscard]] const api::InjectedFault& fault(std::uint64_t id) const {
    for (const auto& one : now.faults->all) {
      if (one.id == id) return one;
    }
    throw std::runtime_error("no such fault");
  }

  [[nodiscard]] const api::RobotSnapshot& robot(int index) const {
    return now.robots[static_cast<std::size_t>(index)];
  }
  [[nodiscard]] const api::RobotDescription& description(int index) const {
    return now.cell->robots[static_cast<std::size_t>(index)];
  }
  /// Where the tool is, in the robot's frame, whatever the robot says.
  [[nodiscard]] Eigen::Isometry3d true_X_RT(int index) const {
    const auto& about = description(index);
    return (about.X_WB.isometry() * about.X_BR.isometry()).inverse() * robot(index).X_WT.isometry();
  }
  /// From where the robot says that the tool is to where it is.
  [[nodiscard]] Eigen::Isometry3d error(int index) const {
    return robot(index).X_RT.isometry().inverse() * true_X_RT(index);
  }

  /// Commands without waiting for the end.
  void tell(int index, api::RobotAction action) {
    world.apply(++fault_ticket_, api::RobotCommand{index, std::move(action), {}});
  }
  void run_belt(double speed_m_s, bool forward = true) {
    world.apply(++fault_ticket_, api::ConveyorCommand{.run = true,
                                                      .forward = forward,
                                                      .speed_m_s = speed_m_s,
                                                      .emergency_stop = {},
                                                      .watchdog_s = {}});
  }

  /// The Fanuc holds this gear, a little above its slot.
  void grasp(const std::string& gear) {
    const auto& about = description(kFanucArm);
    const Eigen::Isometry3d X_RW = (about.X_WB.isometry() * about.X_BR.isometry()).inverse();
    const double grip_z = now.cell->bodies[body(gear)].disc_height_m + 0.004;
    const Eigen::Vector3d grip = X_WB(gear) * Eigen::Vector3d(0, 0, grip_z);
    const Eigen::Vector3d up(0, 0, 0.06);
    act(kFanucArm, api::InitRobot{});
    act(kFanucArm, api::SetGripper{1});
    act(kFanucArm, api::MoveTo{Pose::from(X_RW * tool_down(grip + up, 0)), false});
    act(kFanucArm, api::MoveTo{Pose::from(X_RW * tool_down(grip, 0)), true});
    act(kFanucArm, api::SetGripper{0});
    act(kFanucArm, api::MoveTo{Pose::from(X_RW * tool_down(grip + up, 0)), true});
    if (!robot(kFanucArm).gripper.holding) throw std::runtime_error("it holds nothing");
  }

 private:
  api::Ticket fault_ticket_ = 1'000'000;  // apart from the script's
};

inline api::MoveJoints turn(int joint, double to_rad, double speed_rad_s = 0.5) {
  return {
      {{.joint = joint, .position_rad = to_rad, .speed_rad_s = speed_rad_s, .accel_rad_s2 = {}}}};
}

}  // namespace aprsim::test
