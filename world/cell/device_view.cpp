#include "world/cell/device_view.hpp"

namespace aprsim::world {
namespace {

device::Vector3 vector_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

device::Pose pose_of(const Eigen::Vector3d& p, const Eigen::Quaterniond& q) {
  return {vector_of(p), q.w(), q.x(), q.y(), q.z()};
}

}  // namespace

const device::Cell& DeviceView::of(const Parts& parts) {
  read_bodies(parts);
  read_robots(parts);
  read_belt(parts);
  cell_ = {.step = parts.step,
           .time_s = std::chrono::duration<double>(parts.time).count(),
           .step_s = parts.settings.step_s,
           .bodies = bodies_,
           .robots = robots_,
           .photo_eyes = photo_eyes_,
           .belt = parts.conveyor != nullptr ? &belt_ : nullptr};
  return cell_;
}

void DeviceView::read_bodies(const Parts& parts) {
  bodies_.resize(parts.settings.bodies.size());
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const physics::BodyState state = parts.physics.body(static_cast<int>(i));
    const scene::FreeBody& body = parts.settings.bodies[i];
    bodies_[i] = {.name = body.name,
                  .type = body.type,
                  .mass_kg = body.mass_kg,
                  .pose = pose_of(state.p_WB, state.q_WB),
                  .velocity = vector_of(state.v_W),
                  .angular_velocity = vector_of(state.omega_W),
                  .lost = state.lost_step.has_value()};
  }
}

void DeviceView::read_robots(const Parts& parts) {
  robots_.resize(parts.robots.size());
  joints_.resize(parts.robots.size());
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    const SimulatedRobot& robot = parts.robots[i];
    joints_[i].assign(robot.q().begin(), robot.q().end());
    const Eigen::Isometry3d X_WT = robot.X_WT();
    const physics::GripperState gripper = parts.physics.gripper(static_cast<int>(i));
    robots_[i] = {.name = parts.robot_names[i],
                  .joints = joints_[i],
                  .tool = pose_of(X_WT.translation(), Eigen::Quaterniond(X_WT.linear())),
                  .separation_m = gripper.separation_m,
                  .held_body = gripper.holding ? gripper.held_body : -1,
                  .stopped = robot.stopped_by_protection()};
  }
}

void DeviceView::read_belt(const Parts& parts) {
  photo_eyes_.clear();
  if (parts.conveyor == nullptr) return;
  const api::ConveyorSnapshot& belt = parts.conveyor->state();
  belt_ = {.run = belt.run, .speed_m_s = belt.speed_m_s, .travel_m = belt.travel_m};
  if (parts.photo_eyes == nullptr || !parts.settings.conveyor) return;
  const auto& eyes = parts.settings.conveyor->photo_eyes;
  const auto seen = parts.photo_eyes->eyes();
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    photo_eyes_.push_back({.name = eyes[i].name, .broken = seen[i].broken, .count = seen[i].count});
  }
}

}  // namespace aprsim::world
