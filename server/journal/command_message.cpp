#include "server/journal/command_message.hpp"

#include <limits>
#include <string>
#include <utility>

#include "protocols/messages/control_request.hpp"
#include "protocols/messages/write_message.hpp"

namespace aprsim::server::journal {
namespace {

// ---- to messages

/// Enumerations of the messages are those of the world with an unspecified value before them.
template <typename Message, typename Value>
Message numbered(Value value) {
  return static_cast<Message>(static_cast<int>(value) + 1);
}

void write(const api::LimitSetting& setting, v1::LimitSetting& message) {
  message.set_relative(setting.relative);
  message.set_value(setting.value);
}

void write_target(const Pose& X_RT, const api::PoseLimits& limits,
                  const api::PoseTolerance& tolerance, v1::PoseTarget& message) {
  protocols::write_message(X_RT, *message.mutable_tool_in_robot());
  if (limits.trans_speed) write(*limits.trans_speed, *message.mutable_trans_speed());
  if (limits.trans_accel) write(*limits.trans_accel, *message.mutable_trans_accel());
  if (limits.rot_speed) write(*limits.rot_speed, *message.mutable_rot_speed());
  if (limits.rot_accel) write(*limits.rot_accel, *message.mutable_rot_accel());
  if (tolerance.x_m) message.set_tolerance_x_m(*tolerance.x_m);
  if (tolerance.y_m) message.set_tolerance_y_m(*tolerance.y_m);
  if (tolerance.z_m) message.set_tolerance_z_m(*tolerance.z_m);
  if (tolerance.x_axis_rad) message.set_tolerance_x_axis_rad(*tolerance.x_axis_rad);
  if (tolerance.z_axis_rad) message.set_tolerance_z_axis_rad(*tolerance.z_axis_rad);
}

void write(const api::Waypoint& waypoint, v1::PoseTarget& message) {
  write_target(waypoint.X_RT, waypoint.limits, waypoint.tolerance, message);
}

void write(const api::Guard& guard, v1::Guard& message) {
  message.set_signal(numbered<v1::GuardSignal>(guard.signal.kind));
  message.set_index(guard.signal.index);
  message.set_reversed(guard.signal.reversed);
  message.set_limit(numbered<v1::GuardLimit>(guard.limit));
  message.set_value(guard.value);
  protocols::write_message(guard.recheck, *message.mutable_recheck());
  message.set_require_trigger(guard.require_trigger);
  message.set_error_on_trigger(guard.error_on_trigger);
  message.set_label(guard.label);
}

void write(const api::InitRobot&, v1::RobotCommand& message) { message.mutable_init(); }
void write(const api::EndRobot&, v1::RobotCommand& message) { message.mutable_end(); }
void write(const api::StopMotion& stop, v1::RobotCommand& message) {
  message.mutable_stop()->set_kind(numbered<v1::StopKind>(stop.kind));
}
void write(const api::MoveTo& move, v1::RobotCommand& message) {
  auto& to = *message.mutable_move_to();
  write_target(move.X_RT, move.limits, move.tolerance, *to.mutable_target());
  to.set_straight(move.straight);
}
void write(const api::MoveThroughTo& move, v1::RobotCommand& message) {
  auto& through = *message.mutable_move_through();
  for (const auto& waypoint : move.waypoints) write(waypoint, *through.add_waypoints());
  through.set_straight(move.straight);
}
void write(const api::MoveScrew& move, v1::RobotCommand& message) {
  auto& screw = *message.mutable_screw();
  if (move.start) write(*move.start, *screw.mutable_start());
  if (move.axis_point_R)
    protocols::write_message(*move.axis_point_R, *screw.mutable_axis_point_m());
  screw.set_free_m(move.free_m);
  screw.set_screw_m(move.screw_m);
  screw.set_turn_rad(move.turn_rad);
}
void write(const api::MoveJoints& move, v1::RobotCommand& message) {
  auto& joints = *message.mutable_move_joints();
  for (const api::JointTarget& target : move.targets) {
    auto& to = *joints.add_targets();
    to.set_joint(static_cast<std::uint32_t>(target.joint));
    to.set_position_rad(target.position_rad);
    if (target.speed_rad_s) to.set_speed_rad_s(*target.speed_rad_s);
    if (target.accel_rad_s2) to.set_accel_rad_s2(*target.accel_rad_s2);
    if (target.torque) {
      to.set_torque_nm(target.torque->setting_nm);
      if (target.torque->rate_nm_s) to.set_torque_rate_nm_s(*target.torque->rate_nm_s);
    }
    if (target.tolerance_rad) to.set_tolerance_rad(*target.tolerance_rad);
    for (const api::JointShare& share : target.held) {
      auto& held = *to.add_held();
      held.set_joint(static_cast<std::uint32_t>(share.joint));
      held.set_factor(share.factor);
    }
  }
}
void write(const api::SetGripper& set, v1::RobotCommand& message) {
  message.set_gripper(set.setting);
}
void write(const api::SetGripperForce& set, v1::RobotCommand& message) {
  message.set_gripper_force_n(set.force_n);
}
void write(const api::SetToolChanger& set, v1::RobotCommand& message) {
  message.set_open_tool_changer(set.open);
}
void write(const api::SetOverride& set, v1::RobotCommand& message) {
  message.set_speed_override(set.fraction);
}
void write(const api::Dwell& dwell, v1::RobotCommand& message) {
  protocols::write_message(dwell.duration, *message.mutable_dwell());
}
void write(const api::SetMotionLimit& set, v1::RobotCommand& message) {
  auto& limit = *message.mutable_motion_limit();
  limit.set_which(numbered<v1::MotionLimit>(set.which));
  limit.mutable_setting()->set_relative(set.relative);
  limit.mutable_setting()->set_value(set.value);
}

void write(const api::RobotCommand& command, v1::JournalCommand& message) {
  auto& robot = *message.mutable_robot();
  robot.set_robot(static_cast<std::uint32_t>(command.robot));
  for (const api::Guard& guard : command.guards) write(guard, *robot.add_guards());
  std::visit([&robot](const auto& action) { write(action, robot); }, command.action);
}

void write(const api::ConveyorCommand& command, v1::JournalCommand& message) {
  auto& to = *message.mutable_conveyor();
  if (command.run) to.set_run(*command.run);
  if (command.forward) to.set_forward(*command.forward);
  if (command.speed_m_s) to.set_speed_m_s(*command.speed_m_s);
  if (command.emergency_stop) to.set_emergency_stop(*command.emergency_stop);
  to.set_fault_reset(command.fault_reset);
  if (command.watchdog_s) to.set_watchdog_s(*command.watchdog_s);
}

void write(const api::SetIntruder& command, v1::JournalCommand& message) {
  auto& to = *message.mutable_intruder();
  if (!command.intruder) return;
  protocols::write_message(command.intruder->X_WI,
                           *to.mutable_intruder()->mutable_intruder_in_world());
  protocols::write_message(command.intruder->size_m, *to.mutable_intruder()->mutable_size_m());
}

void write(std::monostate, v1::InjectFaultRequest&) {}
void write(const api::AtTime& at, v1::InjectFaultRequest& message) {
  protocols::write_message(at.time, *message.mutable_at());
}
void write(const api::WhenPlaced& when, v1::InjectFaultRequest& message) {
  message.mutable_placed()->set_type(when.type);
  message.mutable_placed()->set_robot(when.robot);
}
void write(const api::WhenGrasped& when, v1::InjectFaultRequest& message) {
  message.mutable_grasped()->set_robot(when.robot);
  message.mutable_grasped()->set_count(static_cast<std::uint32_t>(when.count));
}
void write(const api::WhenBeamBroken& when, v1::InjectFaultRequest& message) {
  message.mutable_beam()->set_eye(when.eye);
}
void write(const api::WhenCrossing& when, v1::InjectFaultRequest& message) {
  protocols::write_message(when, *message.mutable_crossing());
}
void write(const api::WhenReported& when, v1::InjectFaultRequest& message) {
  message.mutable_reported()->set_event(when.event);
}

void write(const api::InjectFault& fault, v1::JournalCommand& message) {
  auto& to = *message.mutable_inject_fault();
  to.set_kind(fault.kind);
  to.set_target(fault.target);
  for (const auto& [name, value] : fault.parameters) (*to.mutable_parameters())[name] = value;
  std::visit([&to](const auto& trigger) { write(trigger, to); }, fault.trigger);
  if (fault.duration) protocols::write_message(*fault.duration, *to.mutable_duration());
}
void write(const api::EndFault& fault, v1::JournalCommand& message) {
  message.set_end_fault(fault.id);
}
void write(const api::ReportEvent& report, v1::JournalCommand& message) {
  message.set_report_event(report.event);
}
void write(const api::FaultCommand& command, v1::JournalCommand& message) {
  std::visit([&message](const auto& body) { write(body, message); }, command);
}

void write(const api::Pause&, v1::SimulationCommand& message) { message.set_pause(true); }
void write(const api::Resume&, v1::SimulationCommand& message) { message.set_resume(true); }
void write(const api::StepBy& step, v1::SimulationCommand& message) {
  message.set_step_by(step.steps);
}
void write(const api::SetSpeed& speed, v1::SimulationCommand& message) {
  message.set_speed(speed.factor.value_or(std::numeric_limits<double>::infinity()));
}
void write(const api::Reset& reset, v1::SimulationCommand& message) {
  auto& to = *message.mutable_reset();
  if (reset.seed) to.set_seed(*reset.seed);
  if (!reset.next) return;
  to.set_scene(reset.next->name());
  to.set_scene_text(reset.next->text());
}
void write(const api::SaveState& state, v1::SimulationCommand& message) {
  message.set_save_state(state.name);
}
void write(const api::LoadState& state, v1::SimulationCommand& message) {
  message.set_load_state(state.name);
}
void write(const api::DeleteState& state, v1::SimulationCommand& message) {
  message.set_delete_state(state.name);
}
void write(const api::RunUntil& run, v1::SimulationCommand& message) {
  protocols::write_message(run, *message.mutable_run_until());
}
void write(const api::EndRun& end, v1::SimulationCommand& message) { message.set_end_run(end.run); }
void write(const api::SimulationCommand& command, v1::JournalCommand& message) {
  auto& to = *message.mutable_simulation();
  std::visit([&to](const auto& body) { write(body, to); }, command);
}

void write(const api::SpawnBody& spawn, v1::JournalCommand& message) {
  protocols::write_message(spawn, *message.mutable_spawn_body());
}
void write(const api::MoveBody& move, v1::JournalCommand& message) {
  protocols::write_message(move, *message.mutable_move_body());
}
void write(const api::RemoveBody& remove, v1::JournalCommand& message) {
  protocols::write_message(remove, *message.mutable_remove_body());
}
void write(const api::SetSceneValue& set, v1::JournalCommand& message) {
  protocols::write_message(set, *message.mutable_set_scene_value());
}
void write(const api::SceneCommand& command, v1::JournalCommand& message) {
  std::visit([&message](const auto& body) { write(body, message); }, command);
}

// ---- from messages

tl::unexpected<Error> unknown(const std::string& field) {
  return fail(ErrorCode::kInvalidArgument, field,
              "the journal has no " + field + " that this version knows");
}

/// The value of a message's enumeration; `last`: the greatest that there is.
template <typename Value>
Result<Value> value_of(int number, Value last, const char* field) {
  if (number < 1 || number > static_cast<int>(last) + 1) return unknown(field);
  return static_cast<Value>(number - 1);
}

Eigen::Vector3d vector_of(const v1::Vector3& v) { return {v.x(), v.y(), v.z()}; }

Pose pose_of(const v1::Pose& pose) {
  const auto& q = pose.orientation();
  return {vector_of(pose.position_m()), Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z())};
}

SimTime span_of(const google::protobuf::Duration& span) {
  return std::chrono::seconds(span.seconds()) + std::chrono::nanoseconds(span.nanos());
}

api::LimitSetting setting_of(const v1::LimitSetting& setting) {
  return {setting.relative(), setting.value()};
}

api::Waypoint waypoint_of(const v1::PoseTarget& from) {
  api::Waypoint to{.X_RT = pose_of(from.tool_in_robot())};
  if (from.has_trans_speed()) to.limits.trans_speed = setting_of(from.trans_speed());
  if (from.has_trans_accel()) to.limits.trans_accel = setting_of(from.trans_accel());
  if (from.has_rot_speed()) to.limits.rot_speed = setting_of(from.rot_speed());
  if (from.has_rot_accel()) to.limits.rot_accel = setting_of(from.rot_accel());
  if (from.has_tolerance_x_m()) to.tolerance.x_m = from.tolerance_x_m();
  if (from.has_tolerance_y_m()) to.tolerance.y_m = from.tolerance_y_m();
  if (from.has_tolerance_z_m()) to.tolerance.z_m = from.tolerance_z_m();
  if (from.has_tolerance_x_axis_rad()) to.tolerance.x_axis_rad = from.tolerance_x_axis_rad();
  if (from.has_tolerance_z_axis_rad()) to.tolerance.z_axis_rad = from.tolerance_z_axis_rad();
  return to;
}

Result<api::Guard> guard_of(const v1::Guard& from) {
  const auto signal = value_of(from.signal(), api::SignalKind::kLightCurtain, "guard's signal");
  if (!signal) return tl::unexpected(signal.error());
  const auto limit = value_of(from.limit(), api::GuardLimit::kDecreased, "guard's limit");
  if (!limit) return tl::unexpected(limit.error());
  return api::Guard{.signal = {*signal, from.index(), from.reversed()},
                    .limit = *limit,
                    .value = from.value(),
                    .recheck = span_of(from.recheck()),
                    .require_trigger = from.require_trigger(),
                    .error_on_trigger = from.error_on_trigger(),
                    .label = from.label()};
}

api::MoveScrew screw_of(const v1::ScrewAction& from) {
  api::MoveScrew to{
      .free_m = from.free_m(), .screw_m = from.screw_m(), .turn_rad = from.turn_rad()};
  if (from.has_start()) to.start = waypoint_of(from.start());
  if (from.has_axis_point_m()) to.axis_point_R = vector_of(from.axis_point_m());
  return to;
}

api::MoveJoints joints_of(const v1::MoveJointsAction& from) {
  api::MoveJoints move;
  for (const v1::JointTarget& target : from.targets()) {
    auto& to = move.targets.emplace_back();
    to.joint = static_cast<int>(target.joint());
    to.position_rad = target.position_rad();
    if (target.has_speed_rad_s()) to.speed_rad_s = target.speed_rad_s();
    if (target.has_accel_rad_s2()) to.accel_rad_s2 = target.accel_rad_s2();
    if (target.has_torque_nm()) {
      to.torque.emplace().setting_nm = target.torque_nm();
      if (target.has_torque_rate_nm_s()) to.torque->rate_nm_s = target.torque_rate_nm_s();
    }
    if (target.has_tolerance_rad()) to.tolerance_rad = target.tolerance_rad();
    for (const v1::JointShare& share : target.held()) {
      to.held.push_back({static_cast<int>(share.joint()), share.factor()});
    }
  }
  return move;
}

Result<api::RobotAction> action_of(const v1::RobotCommand& from) {
  switch (from.action_case()) {
    case v1::RobotCommand::kInit:
      return api::InitRobot{};
    case v1::RobotCommand::kEnd:
      return api::EndRobot{};
    case v1::RobotCommand::kStop:
      return value_of(from.stop().kind(), api::StopKind::kNormal, "stop's kind")
          .map([](api::StopKind kind) { return api::RobotAction(api::StopMotion{kind}); });
    case v1::RobotCommand::kMoveTo: {
      const api::Waypoint to = waypoint_of(from.move_to().target());
      return api::MoveTo{to.X_RT, from.move_to().straight(), to.limits, to.tolerance};
    }
    case v1::RobotCommand::kMoveThrough: {
      api::MoveThroughTo move{.waypoints = {}, .straight = from.move_through().straight()};
      for (const v1::PoseTarget& waypoint : from.move_through().waypoints()) {
        move.waypoints.push_back(waypoint_of(waypoint));
      }
      return move;
    }
    case v1::RobotCommand::kScrew:
      return screw_of(from.screw());
    case v1::RobotCommand::kMoveJoints:
      return joints_of(from.move_joints());
    case v1::RobotCommand::kGripper:
      return api::SetGripper{from.gripper()};
    case v1::RobotCommand::kGripperForceN:
      return api::SetGripperForce{from.gripper_force_n()};
    case v1::RobotCommand::kOpenToolChanger:
      return api::SetToolChanger{from.open_tool_changer()};
    case v1::RobotCommand::kSpeedOverride:
      return api::SetOverride{from.speed_override()};
    case v1::RobotCommand::kDwell:
      return api::Dwell{span_of(from.dwell())};
    case v1::RobotCommand::kMotionLimit:
      return value_of(from.motion_limit().which(), api::MotionLimit::kRotAccel, "motion limit")
          .map([&from](api::MotionLimit which) {
            const v1::LimitSetting& setting = from.motion_limit().setting();
            return api::RobotAction(
                api::SetMotionLimit{which, setting.relative(), setting.value()});
          });
    case v1::RobotCommand::ACTION_NOT_SET:
      break;
  }
  return unknown("action of a robot");
}

Result<api::RobotCommand> robot_command_of(const v1::RobotCommand& from) {
  auto action = action_of(from);
  if (!action) return tl::unexpected(action.error());
  api::RobotCommand command{static_cast<int>(from.robot()), *std::move(action)};
  for (const v1::Guard& guard : from.guards()) {
    auto next = guard_of(guard);
    if (!next) return tl::unexpected(next.error());
    command.guards.push_back(*std::move(next));
  }
  return command;
}

api::ConveyorCommand conveyor_command_of(const v1::ConveyorCommand& from) {
  api::ConveyorCommand to;
  if (from.has_run()) to.run = from.run();
  if (from.has_forward()) to.forward = from.forward();
  if (from.has_speed_m_s()) to.speed_m_s = from.speed_m_s();
  if (from.has_emergency_stop()) to.emergency_stop = from.emergency_stop();
  to.fault_reset = from.fault_reset();
  if (from.has_watchdog_s()) to.watchdog_s = from.watchdog_s();
  return to;
}

api::SetIntruder intruder_command_of(const v1::IntruderCommand& from) {
  if (!from.has_intruder()) return {};
  return {api::Intruder{pose_of(from.intruder().intruder_in_world()),
                        vector_of(from.intruder().size_m())}};
}

Result<api::SimulationCommand> simulation_command_of(const v1::SimulationCommand& from) {
  switch (from.command_case()) {
    case v1::SimulationCommand::kPause:
      return api::Pause{};
    case v1::SimulationCommand::kResume:
      return api::Resume{};
    case v1::SimulationCommand::kStepBy:
      return api::StepBy{from.step_by()};
    case v1::SimulationCommand::kSpeed: {
      const bool fastest = from.speed() == std::numeric_limits<double>::infinity();
      return api::SetSpeed{fastest ? std::nullopt : std::optional(from.speed())};
    }
    case v1::SimulationCommand::kReset: {
      api::Reset reset;
      if (from.reset().has_seed()) reset.seed = from.reset().seed();
      reset.scene_name = from.reset().scene();
      reset.scene_text = from.reset().scene_text();
      return reset;
    }
    case v1::SimulationCommand::kSaveState:
      return api::SaveState{from.save_state()};
    case v1::SimulationCommand::kLoadState:
      return api::LoadState{from.load_state()};
    case v1::SimulationCommand::kDeleteState:
      return api::DeleteState{from.delete_state()};
    case v1::SimulationCommand::kRunUntil:
      return protocols::to_command(from.run_until()).map([](api::RunUntil run) {
        return api::SimulationCommand(std::move(run));
      });
    case v1::SimulationCommand::kEndRun:
      return api::EndRun{from.end_run()};
    case v1::SimulationCommand::COMMAND_NOT_SET:
      break;
  }
  return unknown("command of the simulation");
}

}  // namespace

void write_message(const api::Command& command, v1::JournalCommand& message) {
  message.set_endpoint(command.endpoint);
  std::visit([&message](const auto& body) { write(body, message); }, command.body);
}

Result<api::Command> to_command(const v1::JournalCommand& message) {
  api::Command command;
  command.endpoint = message.endpoint();
  const auto with = [&command](auto&& body) {
    command.body = std::forward<decltype(body)>(body);
    return command;
  };
  switch (message.body_case()) {
    case v1::JournalCommand::kRobot:
      return robot_command_of(message.robot()).map(with);
    case v1::JournalCommand::kConveyor:
      return with(conveyor_command_of(message.conveyor()));
    case v1::JournalCommand::kIntruder:
      return with(intruder_command_of(message.intruder()));
    case v1::JournalCommand::kInjectFault:
      return protocols::to_command(message.inject_fault()).map([&with](api::InjectFault fault) {
        return with(api::FaultCommand(std::move(fault)));
      });
    case v1::JournalCommand::kEndFault:
      return with(api::FaultCommand(api::EndFault{message.end_fault()}));
    case v1::JournalCommand::kSpawnBody:
      return with(api::SceneCommand(protocols::to_command(message.spawn_body())));
    case v1::JournalCommand::kMoveBody:
      return with(api::SceneCommand(protocols::to_command(message.move_body())));
    case v1::JournalCommand::kRemoveBody:
      return with(api::SceneCommand(protocols::to_command(message.remove_body())));
    case v1::JournalCommand::kSetSceneValue:
      return with(api::SceneCommand(protocols::to_command(message.set_scene_value())));
    case v1::JournalCommand::kReportEvent:
      return with(api::FaultCommand(api::ReportEvent{message.report_event()}));
    case v1::JournalCommand::kSimulation:
      return simulation_command_of(message.simulation()).map(with);
    case v1::JournalCommand::BODY_NOT_SET:
      break;
  }
  return unknown("command");
}

}  // namespace aprsim::server::journal
