#include <algorithm>
#include <cstddef>

#include "protocols/messages/state_hash.hpp"
#include "protocols/messages/write_message.hpp"
#include "world/api/snapshot/contact_names.hpp"

namespace aprsim::protocols {
namespace {

v1::ActionState action_state(api::ActionState state) {
  switch (state) {
    case api::ActionState::kNone:
      return v1::ACTION_STATE_NONE;
    case api::ActionState::kWorking:
      return v1::ACTION_STATE_WORKING;
    case api::ActionState::kDone:
      return v1::ACTION_STATE_DONE;
    case api::ActionState::kError:
      return v1::ACTION_STATE_ERROR;
  }
  return v1::ACTION_STATE_UNSPECIFIED;
}

/// Both enumerations have the same order.
v1::ActionKind action_kind(api::ActionKind kind) {
  static_assert(static_cast<int>(api::ActionKind::kMotionLimit) == v1::ACTION_KIND_MOTION_LIMIT);
  return static_cast<v1::ActionKind>(kind);
}

v1::DriveFault drive_fault(api::DriveFault fault) {
  switch (fault) {
    case api::DriveFault::kNone:
      break;
    case api::DriveFault::kEmergencyStop:
      return v1::DRIVE_FAULT_EMERGENCY_STOP;
    case api::DriveFault::kWatchdog:
      return v1::DRIVE_FAULT_WATCHDOG;
    case api::DriveFault::kLightCurtain:
      return v1::DRIVE_FAULT_LIGHT_CURTAIN;
  }
  return v1::DRIVE_FAULT_UNSPECIFIED;
}

v1::GroupKind group_kind(api::GroupKind kind) {
  switch (kind) {
    case api::GroupKind::kNone:
      break;
    case api::GroupKind::kJoined:
      return v1::GROUP_KIND_JOINED;
    case api::GroupKind::kMerged:
      return v1::GROUP_KIND_MERGED;
    case api::GroupKind::kDormant:
      return v1::GROUP_KIND_DORMANT;
  }
  return v1::GROUP_KIND_UNSPECIFIED;
}

void write(const api::GripperSnapshot& gripper, const api::CellDescription& cell,
           v1::GripperState& message) {
  message.set_setting(gripper.setting);
  message.set_separation_m(gripper.separation_m);
  for (const double travel : gripper.travel_m) message.add_travel_m(travel);
  for (const double force : gripper.force_n) message.add_force_n(force);
  message.set_holding(gripper.holding);
  if (gripper.held_body >= 0) {
    const auto index = static_cast<std::size_t>(gripper.held_body);
    if (index < cell.bodies.size()) {
      message.set_held_body(cell.bodies[index].name);
      message.set_held_index(static_cast<std::uint32_t>(index));
      message.set_held_kind(body_kind(cell.bodies[index].kind));
    }
  }
  message.set_palm_deflection_m(gripper.palm_deflection_m);
  message.set_vacuum_pa(gripper.vacuum_pa);
}

void write(const api::VisionFrame& frame, const api::CellDescription& cell,
           v1::VisionFrame& message) {
  message.set_number(frame.number);
  write_message(frame.time, *message.mutable_sim_time());
  for (const auto& seen : frame.detections) {
    const auto index = static_cast<std::size_t>(seen.body);
    if (index >= cell.bodies.size()) continue;
    auto& detection = *message.add_detections();
    detection.set_body(cell.bodies[index].name);
    detection.set_x_m(seen.x_m);
    detection.set_y_m(seen.y_m);
    detection.set_rotation_rad(seen.rotation_rad);
    detection.set_score(seen.score);
  }
}

void write(const api::RobotSnapshot& robot, const api::RobotDescription& description,
           const api::CellDescription& cell, v1::RobotState& message) {
  message.set_name(description.name);
  const std::size_t joints = std::min(description.joints.size(), robot.joints.size());
  for (std::size_t i = 0; i < joints; ++i) {
    auto& joint = *message.add_joints();
    joint.set_position_rad(robot.joints[i].position_rad);
    joint.set_velocity_rad_s(robot.joints[i].velocity_rad_s);
    joint.set_torque_nm(robot.joints[i].torque_nm);
  }
  write_message(robot.X_WT, *message.mutable_tool_in_world());
  write_message(robot.X_RT, *message.mutable_tool_in_reference());
  write_message(robot.v_RT, *message.mutable_tool_velocity_m_s());
  write_message(robot.omega_RT, *message.mutable_tool_angular_velocity_rad_s());
  write_message(robot.force_T_R, *message.mutable_tool_force_n());
  write_message(robot.torque_T_R, *message.mutable_tool_torque_nm());
  write(robot.gripper, cell, *message.mutable_gripper());
  message.mutable_action()->set_ticket(robot.action.ticket);
  message.mutable_action()->set_state(action_state(robot.action.state));
  message.mutable_action()->set_description(robot.action.description);
  message.mutable_action()->set_kind(action_kind(robot.action.kind));
  message.set_initialized(robot.initialized);
  message.set_protective_stop(robot.protective_stop);
  message.set_moving(robot.moving);
  message.set_drives_on(robot.drives_on);
  write(robot.vision, cell, *message.mutable_vision());
  if (robot.X_RG) write_message(*robot.X_RG, *message.mutable_goal_in_reference());
  if (robot.tool >= 0) message.set_tool(static_cast<std::uint32_t>(robot.tool));
}

void write(const api::BodySnapshot& body, const api::BodyDescription& description,
           v1::BodyState& message) {
  message.set_name(description.name);
  message.set_type(description.type);
  message.set_kind(body_kind(description.kind));
  write_message(body.X_WB, *message.mutable_body_in_world());
  write_message(body.v_W, *message.mutable_velocity_m_s());
  write_message(body.omega_W, *message.mutable_angular_velocity_rad_s());
  message.set_resting(body.resting);
  message.set_group_kind(group_kind(body.group_kind));
  if (body.group >= 0) message.set_group(static_cast<std::uint32_t>(body.group));
  if (body.lost_step) message.set_lost_step(*body.lost_step);
}

void write(const api::ToolSnapshot& tool, const api::ToolDescription& description,
           v1::ToolState& message) {
  message.set_name(description.name);
  write_message(tool.X_WT, *message.mutable_tool_in_world());
  if (tool.robot >= 0) message.set_robot(static_cast<std::uint32_t>(tool.robot));
  message.set_separation_m(tool.separation_m);
  message.set_resting(tool.resting);
  if (tool.lost_step) message.set_lost_step(*tool.lost_step);
}

void write(const api::ContactSide& side, const api::CellDescription& cell,
           v1::ContactSide& message) {
  const auto index = static_cast<std::uint32_t>(side.index);
  switch (side.kind) {
    case api::ContactSide::Kind::kBody:
      message.set_body(index);
      break;
    case api::ContactSide::Kind::kRobot:
      message.set_robot(index);
      if (index < cell.robots.size()) {
        message.set_part(api::part_name(cell.robots[index], side.part));
      }
      break;
    case api::ContactSide::Kind::kFixed:
      message.set_fixed(index);
      break;
    case api::ContactSide::Kind::kTool:
      message.set_tool(index);
      break;
  }
}

void write(const api::ContactSnapshot& contact, const api::CellDescription& cell,
           v1::Contact& message) {
  write(contact.first, cell, *message.mutable_first());
  write(contact.second, cell, *message.mutable_second());
  write_message(contact.p_W, *message.mutable_point_m());
  write_message(contact.f_W, *message.mutable_force_n());
}

void write(const api::RobotTouch& touch, const api::CellDescription& cell,
           v1::RobotTouch& message) {
  write(touch.first, cell, *message.mutable_first());
  write(touch.second, cell, *message.mutable_second());
  message.set_begin_step(touch.begin_step);
  message.set_last_step(touch.last_step);
  message.set_greatest_n(touch.greatest_n);
}

void write(const api::SolverFailures& failures, v1::SolverFailures& message) {
  message.set_not_converged(failures.not_converged);
  message.set_worst_m_s(failures.worst_m_s);
}

void write(const api::SolverStep& step, v1::SolverStep& message) {
  message.set_iterations(step.iterations);
  message.set_residual_m_s(step.residual_m_s);
}

void write_time(const api::Snapshot& snapshot, v1::Snapshot& message) {
  const auto wall = std::chrono::duration_cast<std::chrono::nanoseconds>(
                        std::chrono::system_clock::now().time_since_epoch())
                        .count();
  message.mutable_sample_time()->set_seconds(wall / 1'000'000'000);
  message.mutable_sample_time()->set_nanos(static_cast<std::int32_t>(wall % 1'000'000'000));
  message.set_epoch(snapshot.epoch);
  message.set_step(snapshot.step);
  write_message(snapshot.time, *message.mutable_sim_time());
  message.set_applied_ticket(snapshot.applied);
  message.set_paused(snapshot.paused);
  if (snapshot.speed_target) message.set_speed_target(*snapshot.speed_target);
  message.set_real_time_factor(snapshot.real_time_factor);
  message.set_missed_steps(snapshot.missed_steps);
  message.set_plan_waits(snapshot.plan_waits);
  write_message(std::chrono::nanoseconds(static_cast<std::int64_t>(snapshot.step_time_s * 1e9)),
                *message.mutable_step_time());
  if (!snapshot.virtual_time) return;
  const api::VirtualTimeState& now = *snapshot.virtual_time;
  auto& time = *message.mutable_virtual_time();
  time.set_paced(now.paced);
  for (const std::string& pacer : now.pacers) time.add_pacers(pacer);
  for (const std::string& pacer : now.awaited) time.add_awaited(pacer);
  time.set_expired(now.expired);
  time.set_fallbacks(now.fallbacks);
  time.set_reproducible(now.reproducible());
}

using Entities = SnapshotParts::Entities;

bool is_among(const std::vector<bool>& chosen, std::size_t index) {
  return index < chosen.size() && chosen[index];
}

bool takes_part(const Entities* entities, const api::ContactSide& side) {
  const auto index = static_cast<std::size_t>(side.index);
  switch (side.kind) {
    case api::ContactSide::Kind::kBody:
      return is_among(entities->bodies, index);
    case api::ContactSide::Kind::kRobot:
      return is_among(entities->robots, index);
    case api::ContactSide::Kind::kTool:
      return is_among(entities->tools, index);
    case api::ContactSide::Kind::kFixed:
      break;
  }
  return false;
}

bool takes_part(const Entities* entities, const api::ContactSide& first,
                const api::ContactSide& second) {
  return entities == nullptr || takes_part(entities, first) || takes_part(entities, second);
}

}  // namespace

void write_message(const api::BodySnapshot& body, const api::BodyDescription& description,
                   v1::BodyState& message) {
  write(body, description, message);
}

namespace {

void write_robots(const api::Snapshot& snapshot, const Entities* entities, v1::Snapshot& message) {
  const api::CellDescription& cell = *snapshot.cell;
  const std::size_t count = std::min(cell.robots.size(), snapshot.robots.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (entities != nullptr && !is_among(entities->robots, i)) continue;
    write(snapshot.robots[i], cell.robots[i], cell, *message.add_robots());
  }
}

void write_bodies(const api::Snapshot& snapshot, const Entities* entities, v1::Snapshot& message) {
  const api::CellDescription& cell = *snapshot.cell;
  const std::size_t count = std::min(cell.bodies.size(), snapshot.bodies.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (entities != nullptr && !is_among(entities->bodies, i)) continue;
    write(snapshot.bodies[i], cell.bodies[i], *message.add_bodies());
  }
}

void write_tools(const api::Snapshot& snapshot, const Entities* entities, v1::Snapshot& message) {
  const api::CellDescription& cell = *snapshot.cell;
  const std::size_t count = std::min(cell.tools.size(), snapshot.tools.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (entities != nullptr && !is_among(entities->tools, i)) continue;
    write(snapshot.tools[i], cell.tools[i], *message.add_tools());
  }
}

void write_contacts(const api::Snapshot& snapshot, const Entities* entities,
                    v1::Snapshot& message) {
  for (const auto& contact : snapshot.contacts) {
    if (!takes_part(entities, contact.first, contact.second)) continue;
    write(contact, *snapshot.cell, *message.add_contacts());
  }
}

}  // namespace

void write_message(const Eigen::Vector3d& vector, v1::Vector3& message) {
  message.set_x(vector.x());
  message.set_y(vector.y());
  message.set_z(vector.z());
}

void write_message(const Pose& pose, v1::Pose& message) {
  write_message(pose.p, *message.mutable_position_m());
  auto& orientation = *message.mutable_orientation();
  orientation.set_w(pose.q.w());
  orientation.set_x(pose.q.x());
  orientation.set_y(pose.q.y());
  orientation.set_z(pose.q.z());
}

void write_message(std::chrono::nanoseconds span, google::protobuf::Duration& message) {
  message.set_seconds(span.count() / 1'000'000'000);
  message.set_nanos(static_cast<std::int32_t>(span.count() % 1'000'000'000));
}

void write_message(const api::ConveyorSnapshot& conveyor,
                   const api::ConveyorDescription& description, v1::ConveyorState& message) {
  message.set_run(conveyor.run);
  message.set_forward(conveyor.forward);
  message.set_speed_setting_m_s(conveyor.speed_setting_m_s);
  message.set_speed_m_s(conveyor.speed_m_s);
  message.set_travel_m(conveyor.travel_m);
  message.set_emergency_stop(conveyor.emergency_stop);
  message.set_fault(drive_fault(conveyor.fault));
  message.set_motor_current_a(conveyor.motor_current_a);
  message.set_load_kg(conveyor.load_kg);
  const std::size_t eyes = std::min(description.photo_eyes.size(), conveyor.photo_eyes.size());
  for (std::size_t i = 0; i < eyes; ++i) {
    auto& eye = *message.add_photo_eyes();
    eye.set_broken(conveyor.photo_eyes[i].broken);
    eye.set_count(conveyor.photo_eyes[i].count);
  }
}

void write_message(const api::LightCurtainSnapshot& curtain,
                   const api::LightCurtainDescription& description,
                   v1::LightCurtainState& message) {
  message.set_broken(curtain.broken);
  const auto beams =
      std::min(static_cast<std::size_t>(description.beams), curtain.distance_m.size());
  for (std::size_t i = 0; i < beams; ++i) message.add_distance_m(curtain.distance_m[i]);
}

void write_message(const api::Snapshot& snapshot, const std::string& instance_id,
                   v1::Snapshot& message, const SnapshotParts& parts) {
  const api::CellDescription& cell = *snapshot.cell;
  const auto wanted = [&](int field) { return !parts.without[static_cast<std::size_t>(field)]; };
  message.set_instance_id(instance_id);
  write_time(snapshot, message);
  if (wanted(v1::Snapshot::kRobotsFieldNumber)) write_robots(snapshot, parts.entities, message);
  if (cell.has_conveyor)
    write_message(snapshot.conveyor, cell.conveyor, *message.mutable_conveyor());
  if (cell.light_curtain) {
    write_message(snapshot.light_curtain, *cell.light_curtain, *message.mutable_light_curtain());
  }
  if (snapshot.intruder) {
    auto& intruder = *message.mutable_intruder();
    write_message(snapshot.intruder->X_WI, *intruder.mutable_intruder_in_world());
    write_message(snapshot.intruder->size_m, *intruder.mutable_size_m());
  }
  if (wanted(v1::Snapshot::kBodiesFieldNumber)) write_bodies(snapshot, parts.entities, message);
  if (wanted(v1::Snapshot::kToolsFieldNumber)) write_tools(snapshot, parts.entities, message);
  message.set_contact_count(static_cast<std::uint32_t>(snapshot.contact_count));
  message.set_virtual_joint_count(static_cast<std::uint32_t>(snapshot.virtual_joint_count));
  if (wanted(v1::Snapshot::kContactsFieldNumber)) write_contacts(snapshot, parts.entities, message);
  message.set_max_penetration_m(snapshot.max_penetration_m);
  message.set_physics_faults(snapshot.physics_faults);
  write(snapshot.solver_failures, *message.mutable_solver_failures());
  write(snapshot.solver_step, *message.mutable_solver_step());
  message.set_world_fault(snapshot.world_fault);
  message.set_world_stops(snapshot.world_stops);
  message.set_last_event(snapshot.last_event);
  message.set_revision(cell.revision);
  if (wanted(v1::Snapshot::kStateHashFieldNumber)) message.set_state_hash(state_hash(snapshot));
  if (snapshot.robot_touches && wanted(v1::Snapshot::kRobotTouchesFieldNumber)) {
    for (const auto& touch : *snapshot.robot_touches) {
      if (!takes_part(parts.entities, touch.first, touch.second)) continue;
      write(touch, cell, *message.add_robot_touches());
    }
  }
  if (!snapshot.faults || !wanted(v1::Snapshot::kInjectedFaultsFieldNumber)) return;
  for (const auto& fault : snapshot.faults->all) {
    write_message(fault, *message.add_injected_faults());
  }
}

}  // namespace aprsim::protocols
