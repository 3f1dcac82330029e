#pragma once

#include "world/api/commands/command.hpp"
#include "world/api/faults/fault_fields.hpp"
#include "world/api/values/value_fields.hpp"
#include "world/base/fields.hpp"

/// The fields of all commands; see world/base/fields.hpp.
namespace aprsim::api {

// Motions.
APRSIM_FIELDS(LimitSetting, FIELD(relative), FIELD(value))
APRSIM_FIELDS(PoseLimits, FIELD(trans_speed), FIELD(trans_accel), FIELD(rot_speed),
              FIELD(rot_accel))
APRSIM_FIELDS(PoseTolerance, FIELD_AS(x_m, tolerance_x_m), FIELD_AS(y_m, tolerance_y_m),
              FIELD_AS(z_m, tolerance_z_m), FIELD_AS(x_axis_rad, tolerance_x_axis_rad),
              FIELD_AS(z_axis_rad, tolerance_z_axis_rad))
APRSIM_FIELDS(MoveTo, FIELD_IN(target, X_RT, tool_in_robot), FIELD(straight),
              INLINED_IN(target, limits), INLINED_IN(target, tolerance), FIELD(may_touch))
APRSIM_FIELDS(Waypoint, FIELD_AS(X_RT, tool_in_robot), INLINED(limits), INLINED(tolerance))
APRSIM_FIELDS(MoveThroughTo, FIELD(waypoints), FIELD(straight))
APRSIM_FIELDS(MoveScrew, FIELD(start), FIELD_AS(axis_point_R, axis_point_m), FIELD(free_m),
              FIELD(screw_m), FIELD(turn_rad))
APRSIM_FIELDS(JointTorque, FIELD_AS(setting_nm, torque_nm), FIELD_AS(rate_nm_s, torque_rate_nm_s))
APRSIM_FIELDS(JointTarget, FIELD(joint), FIELD(position_rad), FIELD(speed_rad_s),
              FIELD(accel_rad_s2), INLINED(torque), FIELD(tolerance_rad), FIELD(held))
APRSIM_FIELDS(MoveJoints, FIELD(targets), FIELD(may_touch))

// The other commands to one robot.
APRSIM_FIELDS(InitRobot)
APRSIM_FIELDS(EndProgram)
APRSIM_FIELDS(StopMotion, FIELD(kind))
APRSIM_FIELDS(SetGripper, ALONE(setting))
APRSIM_FIELDS(SetToolChanger, ALONE(open))
APRSIM_FIELDS(SetOverride, ALONE(fraction))
APRSIM_FIELDS(SetGripperForce, ALONE(force_n))
APRSIM_FIELDS(Dwell, ALONE(duration))
APRSIM_FIELDS(SetMotionLimit, FIELD(which), FIELD_IN(setting, relative, relative),
              FIELD_IN(setting, value, value))
APRSIM_FIELDS(SetPlanning, ALONE(mode))
APRSIM_ALTERNATIVES(RobotAction, "action of a robot", ALTERNATIVE(InitRobot, init),
                    ALTERNATIVE(EndProgram, end), ALTERNATIVE(StopMotion, stop),
                    ALTERNATIVE(MoveTo, move_to), ALTERNATIVE(MoveThroughTo, move_through),
                    ALTERNATIVE(MoveScrew, screw), ALTERNATIVE(MoveJoints, move_joints),
                    ALTERNATIVE(SetGripper, gripper), ALTERNATIVE(SetGripperForce, gripper_force_n),
                    ALTERNATIVE(SetToolChanger, open_tool_changer),
                    ALTERNATIVE(SetOverride, speed_override), ALTERNATIVE(Dwell, dwell),
                    ALTERNATIVE(SetMotionLimit, motion_limit), ALTERNATIVE(SetPlanning, planning))
APRSIM_FIELDS(RobotCommand, FIELD(robot), INLINED(action), FIELD(guards))

// Trajectories.
APRSIM_FIELDS(TrajectoryPoint, FIELD(time), FIELD(position_rad), FIELD(velocity_rad_s),
              FIELD(acceleration_rad_s2))
APRSIM_FIELDS(ClaimMotion, FIELD(commander), FIELD(mode), FIELD(reset), FIELD(takes_over))
APRSIM_FIELDS(AppendPoints, FIELD(stream), FIELD(begins), FIELD(points), FIELD(ends_at))
APRSIM_FIELDS(AppendMove, FIELD(stream), FIELD(position_rad), FIELD(speed), FIELD(rounding),
              FIELD(max_waiting))
APRSIM_FIELDS(StopStream, FIELD(stream))
APRSIM_FIELDS(PauseStream, FIELD(stream), FIELD(paused), FIELD(ends_at))
APRSIM_FIELDS(ReleaseMotion, FIELD(stream), FIELD(when_done))
APRSIM_FIELDS(JointTolerance, FIELD(position_rad), FIELD(velocity_rad_s))
APRSIM_FIELDS(FollowTrajectory, FIELD(commander), FIELD(joint_names), FIELD(points), FIELD(start),
              FIELD(path_tolerance), FIELD(goal_tolerance), FIELD(reset),
              FIELD(goal_time_tolerance))
APRSIM_FIELDS(SwitchGripper, FIELD(setting))
APRSIM_ALTERNATIVES(TrajectoryAction, "action of a trajectory", ALTERNATIVE(ClaimMotion, claim),
                    ALTERNATIVE(AppendPoints, append_points), ALTERNATIVE(AppendMove, append_move),
                    ALTERNATIVE(StopStream, stop), ALTERNATIVE(PauseStream, pause),
                    ALTERNATIVE(ReleaseMotion, release), ALTERNATIVE(FollowTrajectory, follow),
                    ALTERNATIVE(SwitchGripper, switch_gripper))
APRSIM_FIELDS(TrajectoryCommand, FIELD(robot), INLINED(action))

APRSIM_FIELDS(ConveyorCommand, FIELD(run), FIELD(forward), FIELD(speed_m_s), FIELD(emergency_stop),
              FIELD(fault_reset), FIELD(watchdog_s))

APRSIM_FIELDS(SetIntruder, FIELD(intruder))

APRSIM_FIELDS(SignalSetting, FIELD(device), FIELD(signal), FIELD(value))
APRSIM_FIELDS(SetSignals, FIELD(settings))

// The simulation.
APRSIM_FIELDS(Pause)
APRSIM_FIELDS(Resume)
APRSIM_FIELDS(StepBy, ALONE(steps))
APRSIM_FIELDS(SetSpeed, ALONE(factor))
APRSIM_FIELDS(Reset, FIELD(seed), FIELD_AS(scene_name, scene), FIELD(scene_text), NOWHERE(next))
APRSIM_FIELDS(SaveState, ALONE(name), NOWHERE(state))
APRSIM_FIELDS(LoadState, ALONE(name), NOWHERE(state))
APRSIM_FIELDS(DeleteState, ALONE(name))
APRSIM_FIELDS(UntilTime, ALONE(time))
APRSIM_FIELDS(UntilEvent, FIELD(kinds), FIELD(names))
APRSIM_ALTERNATIVES(decltype(RunUntil::until), "condition of a run", NO_ALTERNATIVE,
                    ALTERNATIVE(UntilTime, time), ALTERNATIVE(UntilEvent, event),
                    ALTERNATIVE(WhenCrossing, crossing))
APRSIM_FIELDS(RunUntil, INLINED(until), FIELD_AS(steps, max_steps), NOWHERE(resolved))
APRSIM_FIELDS(EndRun, ALONE(run))
APRSIM_ALTERNATIVES(SimulationCommand, "command of the simulation", ALTERNATIVE(Pause, pause),
                    ALTERNATIVE(Resume, resume), ALTERNATIVE(StepBy, step_by),
                    ALTERNATIVE(SetSpeed, speed), ALTERNATIVE(Reset, reset),
                    ALTERNATIVE(SaveState, save_state), ALTERNATIVE(LoadState, load_state),
                    ALTERNATIVE(DeleteState, delete_state), ALTERNATIVE(RunUntil, run_until),
                    ALTERNATIVE(EndRun, end_run))

// The scene.
APRSIM_FIELDS(SpawnBody, FIELD(type), FIELD(name), FIELD_AS(X_WB, body_in_world))
APRSIM_FIELDS(MoveBody, FIELD(name), FIELD_AS(X_WB, body_in_world))
APRSIM_FIELDS(RemoveBody, FIELD(name))
APRSIM_FIELDS(SetSceneValue, FIELD(path), FIELD(value))
APRSIM_ALTERNATIVES(SceneCommand, "command of the scene", ALTERNATIVE(SpawnBody, spawn_body),
                    ALTERNATIVE(MoveBody, move_body), ALTERNATIVE(RemoveBody, remove_body),
                    ALTERNATIVE(SetSceneValue, set_scene_value))

APRSIM_ALTERNATIVES(decltype(Command::body), "command", ALTERNATIVE(RobotCommand, robot),
                    ALTERNATIVE(ConveyorCommand, conveyor), ALTERNATIVE(SetIntruder, intruder),
                    INLINED_ALTERNATIVE(FaultCommand), ALTERNATIVE(SimulationCommand, simulation),
                    INLINED_ALTERNATIVE(SceneCommand), ALTERNATIVE(TrajectoryCommand, trajectory),
                    ALTERNATIVE(SetSignals, set_signals))
APRSIM_FIELDS(Command, FIELD(endpoint), INLINED(body), NOWHERE(cell))

}  // namespace aprsim::api
