#include "world/cell/device_executor.hpp"

#include <array>
#include <cmath>
#include <variant>

#include "world/api/commands/trajectory_command.hpp"

namespace aprsim::world {

void DeviceExecutor::carry_out(const devices::Action& action) {
  std::visit([this](const auto& one) { act(one); }, action);
}

void DeviceExecutor::act(const devices::RunBelt& run) {
  parts_.conveyor->apply(
      {.run = true, .forward = run.speed_m_s >= 0, .speed_m_s = std::abs(run.speed_m_s)});
}

void DeviceExecutor::act(const devices::StopBelt& /*stop*/) {
  parts_.conveyor->apply({.run = false});
}

void DeviceExecutor::act(const devices::SetGripper& set) {
  // As clients of trajectories switch it: the robot's commands go on. It cannot be refused.
  static_cast<void>(parts_.robots[static_cast<std::size_t>(set.robot)].apply(
      0, api::TrajectoryCommand{.robot = set.robot, .action = api::SwitchGripper{set.setting}}));
}

void DeviceExecutor::act(const devices::StopRobot& stop) {
  parts_.robots[static_cast<std::size_t>(stop.robot)].trip();
}

void DeviceExecutor::act(const devices::Push& push) {
  if (is_lost(push.body)) return;
  parts_.physics.add_impulse(push.body, push.force_W * parts_.step_s,
                             push.torque_W * parts_.step_s);
}

void DeviceExecutor::act(const devices::Place& place) {
  if (is_lost(place.body)) return;
  const std::array<physics::PhysicsWorld::Placement, 1> one{{{place.body, place.X_WB}}};
  parts_.physics.place(one);
}

void DeviceExecutor::act(const devices::Remove& remove) {
  if (!is_lost(remove.body)) parts_.physics.remove(remove.body);
}

bool DeviceExecutor::is_lost(int body) const {
  return parts_.physics.body(body).lost_step.has_value();
}

}  // namespace aprsim::world
