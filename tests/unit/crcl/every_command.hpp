#pragma once

#include <string>
#include <utility>
#include <vector>

#include "crcl/documents.hpp"

namespace aprsim::crcl {

inline Command command(CommandBody body) { return {std::nullopt, 7, {}, std::move(body)}; }

/// One of each kind of command; the name is that of its golden document.
inline std::vector<std::pair<std::string, CommandInstance>> every_command() {
  const Pose pose{{290.01, -260, 50}, {-0.707, -0.707, 0}, {0, 0, -1}};
  PoseSettings settings;
  settings.coordinated = true;
  settings.trans_speed = Rate{true, 0.9};
  settings.rot_speed = Rate{false, 30};
  settings.trans_accel = Rate{false, 500};
  settings.rot_accel = Rate{true, 0.5};
  settings.tolerance = PoseTolerance{0.005, 0.01, std::nullopt, std::nullopt, 1};
  Command guarded = command(MoveTo{true, {pose, std::nullopt}});
  guarded.name = "down";
  guarded.guards = {
      {"g", "ft", "Fz", GuardLimit::kIncreaseOverLimit, 10, 5000, 3, 4, 2.5, true, false}};
  return {
      {"init_canon", {std::nullopt, command(InitCanon{}), std::nullopt, {}, {}}},
      {"end_canon", {"inst", command(EndCanon{}), "prog.xml", 3, 22}},
      {"get_status", {{}, command(GetStatus{}), {}, {}, {}}},
      {"stop_motion", {{}, command(StopMotion{StopCondition::kImmediate}), {}, {}, {}}},
      {"move_to", {{}, command(MoveTo{false, {pose, {}}}), {}, {}, {}}},
      {"move_to_and_set", {{}, command(MoveTo{true, {pose, settings}}), {}, {}, {}}},
      {"move_to_guarded", {{}, guarded, {}, {}, {}}},
      {"move_through_to",
       {{}, command(MoveThroughTo{true, {{pose, settings}, {pose, {}}}}), {}, {}, {}}},
      {"move_screw",
       {{}, command(MoveScrew{Waypoint{pose, {}}, Vector{300, -260, 50}, 5, 10, 720}), {}, {}, {}}},
      {"move_screw_here", {{}, command(MoveScrew{{}, {}, {}, -10, -360}), {}, {}, {}}},
      {"open_tool_changer", {{}, command(OpenToolChanger{}), {}, {}, {}}},
      {"close_tool_changer", {{}, command(CloseToolChanger{}), {}, {}, {}}},
      {"actuate_joints",
       {{},
        command(ActuateJoints{{{1, 10.5, JointSpeedAccel{30, std::nullopt}},
                               {3, -90, JointForceTorque{1.23, 0.5}},
                               {4, 0, JointSpeedAccel{}}},
                              {{1, 0.25}}}),
        {},
        {},
        {}}},
      {"set_end_effector", {{}, command(SetEndEffector{0.25}), {}, {}, {}}},
      {"dwell", {{}, command(Dwell{2.5}), {}, {}, {}}},
      {"message", {{}, command(Message{" <place> & \"go\" "}), {}, {}, {}}},
      {"set_length_units", {{}, command(SetUnits{LengthUnit::kInch}), {}, {}, {}}},
      {"set_angle_units", {{}, command(SetUnits{AngleUnit::kRadian}), {}, {}, {}}},
      {"set_force_units", {{}, command(SetUnits{ForceUnit::kOunce}), {}, {}, {}}},
      {"set_torque_units", {{}, command(SetUnits{TorqueUnit::kFootPound}), {}, {}, {}}},
      {"set_trans_speed", {{}, command(SetRate{RateKind::kTransSpeed, {false, 200}}), {}, {}, {}}},
      {"set_trans_accel", {{}, command(SetRate{RateKind::kTransAccel, {true, 0.75}}), {}, {}, {}}},
      {"set_rot_speed", {{}, command(SetRate{RateKind::kRotSpeed, {true, 0.5}}), {}, {}, {}}},
      {"set_rot_accel", {{}, command(SetRate{RateKind::kRotAccel, {false, 90}}), {}, {}, {}}},
      {"set_end_pose_tolerance",
       {{}, command(SetEndPoseTolerance{{1, {}, {}, {}, 2}}), {}, {}, {}}},
      {"set_intermediate_pose_tolerance",
       {{}, command(SetIntermediatePoseTolerance{{1, 2, 3, 4, 5}}), {}, {}, {}}},
      {"set_default_joint_tolerances",
       {{}, command(SetDefaultJointTolerances{{{1, 0.5}, {2, 1}}}), {}, {}, {}}},
      {"configure_joint_reports",
       {{}, command(ConfigureJointReports{true, {{1, true, false, true}}}), {}, {}, {}}},
      {"configure_status_report",
       {{}, command(ConfigureStatusReport{true, true, true, false, true, false}), {}, {}, {}}},
      {"loop_block_start", {{}, command(LoopBlockStart{"main"}), {}, {}, {}}},
      {"loop_block_end", {{}, command(LoopBlockEnd{"main", 3}), {}, {}, {}}},
      {"set_end_effector_parameters",
       {{}, command(SetEndEffectorParameters{{{"force", "30"}, {"mode", "soft"}}}), {}, {}, {}}},
      {"set_robot_parameters",
       {{}, command(SetRobotParameters{{{"speed_override", "50"}}}), {}, {}, {}}},
      {"enable_gripper", {{}, command(EnableGripper{"gripper.1", {{"a", "b"}}}), {}, {}, {}}},
      {"disable_gripper", {{}, command(DisableGripper{"gripper.1"}), {}, {}, {}}},
      {"enable_sensor", {{}, command(EnableSensor{"ft", {{"a", "b"}}}), {}, {}, {}}},
      {"disable_sensor", {{}, command(DisableSensor{"ft"}), {}, {}, {}}},
      {"enable_robot_parameter_status",
       {{}, command(EnableRobotParameterStatus{"speed_override"}), {}, {}, {}}},
      {"disable_robot_parameter_status",
       {{}, command(DisableRobotParameterStatus{"speed_override"}), {}, {}, {}}},
      {"set_motion_coordination", {{}, command(SetMotionCoordination{true}), {}, {}, {}}},
      {"run_program", {{}, command(RunProgram{"10 GOTO <10>\n"}), {}, {}, {}}},
  };
}

}  // namespace aprsim::crcl
