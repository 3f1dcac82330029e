#pragma once

#include <memory>
#include <vector>

#include "world/robot/controller/equipped_arm.hpp"
#include "world/robot/controller/planning_latency.hpp"
#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/kinematics/inverse_kinematics.hpp"
#include "world/robot/model/arm_model.hpp"
#include "world/robot/planning/plan_job.hpp"

namespace aprsim::robot {

/// A tool that the tool changer can take.
struct ToolSetup {
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();  ///< the frame that poses are of
  Payload payload;  ///< tool and the heaviest part: motions are planned to carry it
};

/// Constants of one robot; SI.
struct ControllerSetup {
  ArmModel model;
  std::shared_ptr<const InverseKinematics> ik;
  Eigen::Isometry3d X_BR = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();       ///< the frame that poses are of
  Eigen::Isometry3d X_FT_open = Eigen::Isometry3d::Identity();  ///< the same without a tool
  JointVector q_home;
  double step_s = 1e-3;
  double max_trans_speed_m_s = 0, max_trans_accel_m_s2 = 0;
  double max_rot_speed_rad_s = 0, max_rot_accel_rad_s2 = 0;
  Payload payload;               ///< gripper and the heaviest part: motions are planned to carry it
  Payload payload_open;          ///< without a tool
  std::vector<ToolSetup> tools;  ///< all tools; none = one, with X_FT and payload
  int tool = 0;                  ///< on the flange at the start, -1 = none
  double tool_change_s = 0;      ///< from the changer's valve to its lock
  Eigen::Vector3d gravity_B{0, 0, -9.81};
  PlanningLatency latency;
  /// Makes plans ahead; null = they are made when they are needed, with the same bits.
  PlanPrefetcher* prefetcher = nullptr;
  api::PlanningMode planning = api::PlanningMode::kDirect;  ///< at the start
  /// The source of surroundings; null = nothing is known, and moves are direct.
  const SurroundingsSource* surroundings = nullptr;
  int index = 0;  ///< of the robot, for the surroundings
};

/// The setup with at least one tool. Throws std::invalid_argument for a setup that makes no robot
/// (no inverse kinematics, step not > 0, home outside the joint limits).
[[nodiscard]] ControllerSetup checked(ControllerSetup setup);

/// The arm with each tool, then without one. `setup` is checked.
[[nodiscard]] std::vector<EquippedArm> equipped_arms(const ControllerSetup& setup);

/// Limits of the tool's motion that no command may exceed.
[[nodiscard]] ToolLimits tool_maximum(const ControllerSetup& setup);

}  // namespace aprsim::robot
