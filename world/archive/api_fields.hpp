#pragma once

#include "world/api/commands/command.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/archive/archive.hpp"

/// The fields of the plain values of world/api, for archive.hpp.
namespace aprsim::archive {

template <typename Io, Of<Pose> Self>
void fields(Io& io, Self& self) {
  auto& [p, q] = self;
  io(p, q);
}

template <typename Io, Of<api::Signal> Self>
void fields(Io& io, Self& self) {
  auto& [kind, index, reversed] = self;
  io(kind, index, reversed);
}

template <typename Io, Of<api::Guard> Self>
void fields(Io& io, Self& self) {
  auto& [signal, limit, value, recheck, require_trigger, error_on_trigger, label] = self;
  io(signal, limit, value, recheck, require_trigger, error_on_trigger, label);
}

template <typename Io, Of<api::GuardSnapshot> Self>
void fields(Io& io, Self& self) {
  auto& [checks, last_check, last_value] = self;
  io(checks, last_check, last_value);
}

template <typename Io, Of<api::GuardsSnapshot> Self>
void fields(Io& io, Self& self) {
  auto& [ticket, count, guards, triggers, stop_time, trigger_guard, trigger_value, trigger_X_RT] =
      self;
  io(ticket, count, guards, triggers, stop_time, trigger_guard, trigger_value, trigger_X_RT);
}

template <typename Io, Of<api::LimitSetting> Self>
void fields(Io& io, Self& self) {
  auto& [relative, value] = self;
  io(relative, value);
}

template <typename Io, Of<api::PoseLimits> Self>
void fields(Io& io, Self& self) {
  auto& [trans_speed, trans_accel, rot_speed, rot_accel] = self;
  io(trans_speed, trans_accel, rot_speed, rot_accel);
}

template <typename Io, Of<api::PoseTolerance> Self>
void fields(Io& io, Self& self) {
  auto& [x_m, y_m, z_m, x_axis_rad, z_axis_rad] = self;
  io(x_m, y_m, z_m, x_axis_rad, z_axis_rad);
}

template <typename Io, Of<api::MoveTo> Self>
void fields(Io& io, Self& self) {
  auto& [X_RT, straight, limits, tolerance] = self;
  io(X_RT, straight, limits, tolerance);
}

template <typename Io, Of<api::Waypoint> Self>
void fields(Io& io, Self& self) {
  auto& [X_RT, limits, tolerance] = self;
  io(X_RT, limits, tolerance);
}

template <typename Io, Of<api::MoveThroughTo> Self>
void fields(Io& io, Self& self) {
  auto& [waypoints, straight] = self;
  io(waypoints, straight);
}

template <typename Io, Of<api::MoveScrew> Self>
void fields(Io& io, Self& self) {
  auto& [start, axis_point_R, free_m, screw_m, turn_rad] = self;
  io(start, axis_point_R, free_m, screw_m, turn_rad);
}

template <typename Io, Of<api::JointTorque> Self>
void fields(Io& io, Self& self) {
  auto& [setting_nm, rate_nm_s] = self;
  io(setting_nm, rate_nm_s);
}

template <typename Io, Of<api::JointShare> Self>
void fields(Io& io, Self& self) {
  auto& [joint, factor] = self;
  io(joint, factor);
}

template <typename Io, Of<api::JointTarget> Self>
void fields(Io& io, Self& self) {
  auto& [joint, position_rad, speed_rad_s, accel_rad_s2, torque, tolerance_rad, held] = self;
  io(joint, position_rad, speed_rad_s, accel_rad_s2, torque, tolerance_rad, held);
}

template <typename Io, Of<api::MoveJoints> Self>
void fields(Io& io, Self& self) {
  auto& [targets] = self;
  io(targets);
}

template <typename Io, Of<api::InitRobot> Self>
void fields(Io&, Self&) {}

template <typename Io, Of<api::EndRobot> Self>
void fields(Io&, Self&) {}

template <typename Io, Of<api::StopMotion> Self>
void fields(Io& io, Self& self) {
  auto& [kind] = self;
  io(kind);
}

template <typename Io, Of<api::SetGripper> Self>
void fields(Io& io, Self& self) {
  auto& [setting] = self;
  io(setting);
}

template <typename Io, Of<api::SetToolChanger> Self>
void fields(Io& io, Self& self) {
  auto& [open] = self;
  io(open);
}

template <typename Io, Of<api::SetOverride> Self>
void fields(Io& io, Self& self) {
  auto& [fraction] = self;
  io(fraction);
}

template <typename Io, Of<api::SetGripperForce> Self>
void fields(Io& io, Self& self) {
  auto& [force_n] = self;
  io(force_n);
}

template <typename Io, Of<api::Dwell> Self>
void fields(Io& io, Self& self) {
  auto& [duration] = self;
  io(duration);
}

template <typename Io, Of<api::SetMotionLimit> Self>
void fields(Io& io, Self& self) {
  auto& [which, relative, value] = self;
  io(which, relative, value);
}

template <typename Io, Of<api::ActionStatus> Self>
void fields(Io& io, Self& self) {
  auto& [ticket, state, description, kind] = self;
  io(ticket, state, description, kind);
}

template <typename Io, Of<api::PhotoEyeSnapshot> Self>
void fields(Io& io, Self& self) {
  auto& [broken, count] = self;
  io(broken, count);
}

template <typename Io, Of<api::ConveyorSnapshot> Self>
void fields(Io& io, Self& self) {
  auto& [run, forward, speed_setting_m_s, speed_m_s, travel_m, emergency_stop, fault,
         motor_current_a, load_kg, photo_eyes] = self;
  io(run, forward, speed_setting_m_s, speed_m_s, travel_m, emergency_stop, fault, motor_current_a,
     load_kg, photo_eyes);
}

template <typename Io, Of<api::LightCurtainSnapshot> Self>
void fields(Io& io, Self& self) {
  auto& [broken, distance_m] = self;
  io(broken, distance_m);
}

template <typename Io, Of<api::Intruder> Self>
void fields(Io& io, Self& self) {
  auto& [X_WI, size_m] = self;
  io(X_WI, size_m);
}

template <typename Io, Of<api::VisionDetection> Self>
void fields(Io& io, Self& self) {
  auto& [body, x_m, y_m, rotation_rad, score] = self;
  io(body, x_m, y_m, rotation_rad, score);
}

template <typename Io, Of<api::VisionFrame> Self>
void fields(Io& io, Self& self) {
  auto& [number, time, detections] = self;
  io(number, time, detections);
}

template <typename Io, Of<api::AtTime> Self>
void fields(Io& io, Self& self) {
  auto& [time] = self;
  io(time);
}

template <typename Io, Of<api::WhenPlaced> Self>
void fields(Io& io, Self& self) {
  auto& [type, robot] = self;
  io(type, robot);
}

template <typename Io, Of<api::WhenGrasped> Self>
void fields(Io& io, Self& self) {
  auto& [robot, count] = self;
  io(robot, count);
}

template <typename Io, Of<api::WhenBeamBroken> Self>
void fields(Io& io, Self& self) {
  auto& [eye] = self;
  io(eye);
}

template <typename Io, Of<api::WhenCrossing> Self>
void fields(Io& io, Self& self) {
  auto& [quantity, robot, joint, above, limit] = self;
  io(quantity, robot, joint, above, limit);
}

template <typename Io, Of<api::WhenReported> Self>
void fields(Io& io, Self& self) {
  auto& [event] = self;
  io(event);
}

template <typename Io, Of<api::InjectedFault> Self>
void fields(Io& io, Self& self) {
  auto& [id, ticket, kind, target, trigger, robot, values, state, begin_step, end_step, note] =
      self;
  io(id, ticket, kind, target, trigger, robot, values, state, begin_step, end_step, note);
}

template <typename Io, Of<api::InjectedFaults> Self>
void fields(Io& io, Self& self) {
  auto& [all] = self;
  io(all);
}

template <typename Io, Of<api::SolverFailures> Self>
void fields(Io& io, Self& self) {
  auto& [not_converged, worst_m_s] = self;
  io(not_converged, worst_m_s);
}

template <typename Io, Of<api::SolverStep> Self>
void fields(Io& io, Self& self) {
  auto& [iterations, residual_m_s] = self;
  io(iterations, residual_m_s);
}

template <typename Io, Of<api::ContactSide> Self>
void fields(Io& io, Self& self) {
  auto& [kind, index, part] = self;
  io(kind, index, part);
}

template <typename Io, Of<api::RobotTouch> Self>
void fields(Io& io, Self& self) {
  auto& [first, second, begin_step, last_step, greatest_n] = self;
  io(first, second, begin_step, last_step, greatest_n);
}

template <typename Io, Of<api::RobotCommand> Self>
void fields(Io& io, Self& self) {
  auto& [robot, action, guards] = self;
  io(robot, action, guards);
}

template <typename Io, Of<api::ConveyorCommand> Self>
void fields(Io& io, Self& self) {
  auto& [run, forward, speed_m_s, emergency_stop, fault_reset, watchdog_s] = self;
  io(run, forward, speed_m_s, emergency_stop, fault_reset, watchdog_s);
}

template <typename Io, Of<api::SetIntruder> Self>
void fields(Io& io, Self& self) {
  auto& [intruder] = self;
  io(intruder);
}

template <typename Io, Of<api::InjectFault> Self>
void fields(Io& io, Self& self) {
  auto& [kind, target, parameters, trigger, duration] = self;
  io(kind, target, parameters, trigger, duration);
}

template <typename Io, Of<api::EndFault> Self>
void fields(Io& io, Self& self) {
  auto& [id] = self;
  io(id);
}

template <typename Io, Of<api::ReportEvent> Self>
void fields(Io& io, Self& self) {
  auto& [event] = self;
  io(event);
}

template <typename Io, Of<api::Pause> Self>
void fields(Io&, Self&) {}

template <typename Io, Of<api::Resume> Self>
void fields(Io&, Self&) {}

template <typename Io, Of<api::StepBy> Self>
void fields(Io& io, Self& self) {
  auto& [steps] = self;
  io(steps);
}

template <typename Io, Of<api::SetSpeed> Self>
void fields(Io& io, Self& self) {
  auto& [factor] = self;
  io(factor);
}

template <typename Io, Of<api::Reset> Self>
void fields(Io& io, Self& self) {
  auto& [seed, scene_name, scene_text, next] = self;
  io(seed, scene_name, scene_text);  // what comes next is made of them
}

template <typename Io, Of<api::SaveState> Self>
void fields(Io& io, Self& self) {
  auto& [name, state] = self;  // commands of the simulation stand in no state
  io(name);
}

template <typename Io, Of<api::LoadState> Self>
void fields(Io& io, Self& self) {
  auto& [name, state] = self;  // commands of the simulation stand in no state
  io(name);
}

template <typename Io, Of<api::DeleteState> Self>
void fields(Io& io, Self& self) {
  auto& [name] = self;
  io(name);
}

template <typename Io, Of<api::UntilTime> Self>
void fields(Io& io, Self& self) {
  auto& [time] = self;
  io(time);
}

template <typename Io, Of<api::UntilEvent> Self>
void fields(Io& io, Self& self) {
  auto& [kinds, names] = self;
  io(kinds, names);
}

template <typename Io, Of<api::RunUntil> Self>
void fields(Io& io, Self& self) {
  auto& [until, steps] = self;
  io(until, steps);
}

template <typename Io, Of<api::EndRun> Self>
void fields(Io& io, Self& self) {
  auto& [run] = self;
  io(run);
}

template <typename Io, Of<api::SpawnBody> Self>
void fields(Io& io, Self& self) {
  auto& [type, name, X_WB] = self;
  io(type, name, X_WB);
}

template <typename Io, Of<api::MoveBody> Self>
void fields(Io& io, Self& self) {
  auto& [name, X_WB] = self;
  io(name, X_WB);
}

template <typename Io, Of<api::RemoveBody> Self>
void fields(Io& io, Self& self) {
  auto& [name] = self;
  io(name);
}

template <typename Io, Of<api::SetSceneValue> Self>
void fields(Io& io, Self& self) {
  auto& [path, value] = self;
  io(path, value);
}

template <typename Io, Of<api::Command> Self>
void fields(Io& io, Self& self) {
  auto& [endpoint, body] = self;
  io(endpoint, body);
}

}  // namespace aprsim::archive
