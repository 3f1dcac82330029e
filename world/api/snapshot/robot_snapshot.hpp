#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "world/api/commands/robot_command.hpp"
#include "world/api/snapshot/motion_snapshot.hpp"
#include "world/api/snapshot/vision.hpp"
#include "world/api/values/guard.hpp"
#include "world/api/values/joint_count.hpp"
#include "world/api/values/planning_mode.hpp"
#include "world/api/values/pose.hpp"
#include "world/api/values/posture.hpp"
#include "world/api/values/ticket.hpp"

/// One robot at a step boundary.
namespace aprsim::api {

struct JointSnapshot {
  double position_rad = 0, velocity_rad_s = 0, torque_nm = 0;
  double tool_lever_m = 0;  ///< distance of the tool point from the joint's axis
};

struct GripperSnapshot {
  double setting = 1;                ///< last commanded, 0 closed .. 1 open
  double separation_m = 0;           ///< pad to pad
  std::array<double, 2> travel_m{};  ///< closing travel of each finger
  /// Normal force of each pad on what it holds; of a cup the suction's, and 0.
  std::array<double, 2> force_n{};
  /// Both pads press on one body, the fingers stopped short; or the cup draws one.
  bool holding = false;
  int held_body = -1;            ///< a gear or tray: index into bodies while holding, else -1
  double palm_deflection_m = 0;  ///< of the compliant mount
  double max_force_n = 0;        ///< of each finger at the pressure that is set
  double vacuum_pa = 0;          ///< of a cup
};

enum class ActionState { kNone, kWorking, kDone, kError };
/// For checks of states (world/archive).
[[nodiscard]] constexpr ActionState last_of(ActionState) { return ActionState::kError; }
/// Progress of the latest command that a robot took.
struct ActionStatus {
  Ticket ticket = 0;
  ActionState state = ActionState::kNone;
  /// When kError: joint or axis, value, limit, unit, and what to do. When kDone: a remark,
  /// mostly empty.
  std::string description;
  ActionKind kind = ActionKind::kNone;
};

struct RobotSnapshot {
  std::array<JointSnapshot, kMaxJoints> joints;    ///< the first joints.size() of the description
  Pose X_WT;                                       ///< tool in world
  Pose X_RT;                                       ///< tool in the robot's reference frame
  Eigen::Vector3d v_RT = Eigen::Vector3d::Zero();  ///< tool point velocity in R [m/s]
  Eigen::Vector3d omega_RT = Eigen::Vector3d::Zero();  ///< angular velocity in R [rad/s]
  /// Contact force on flange and gripper in R [N], what the gripper holds included: its weight, its
  /// inertia and what it meets. Zero with nothing held and nothing touched: the gripper's own
  /// weight is tared.
  Eigen::Vector3d force_T_R = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque_T_R = Eigen::Vector3d::Zero();  ///< about the tool point, in R [Nm]
  GripperSnapshot gripper;
  LimitSetting trans_speed, trans_accel, rot_speed, rot_accel;
  double override_fraction = 1;  ///< of every motion's speed, as set
  bool tool_mounted = true;      ///< false: nothing is on the flange, T is the flange frame
  int tool = -1;                 ///< on the flange: index into tools, -1 = none
  ActionStatus action;
  PlanningMode planning = PlanningMode::kDirect;
  /// Positions of the tool point in R along the running or latest motion that was checked against
  /// the surroundings [m]; null = there is none.
  std::shared_ptr<const std::vector<Eigen::Vector3d>> planned_path;
  std::optional<Pose> X_RG;      ///< where the running motion is to take the tool
  bool initialized = false;      ///< InitRobot taken since start or a held error
  bool protective_stop = false;  ///< tripped; held until InitRobot
  bool moving = false;
  bool drives_on = true;  ///< false: the brakes hold, since a stop; motion switches them on again
  bool light_curtain_broken = false;  ///< the robot's input from the cell's curtain
  Posture posture;
  GuardsSnapshot guards;
  MotionSnapshot motion;
  VisionFrame vision;  ///< the latest that its camera gave out
};

}  // namespace aprsim::api
