#include "world/cell/robot/robot_readings.hpp"

#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::world {

void write_motion(const robot::ServoArm& arm, const Eigen::Isometry3d& X_BR,
                  const Eigen::Isometry3d& X_FT, api::RobotSnapshot& out) {
  const robot::ArmModel& model = arm.model();
  const Eigen::Isometry3d X_BF = robot::flange_pose(model, arm.q());
  const Eigen::Isometry3d X_RB = X_BR.inverse();
  out.X_RT = Pose::from(X_RB * X_BF * X_FT);
  const auto J = robot::point_jacobian(model, arm.q(), model.dof(), X_FT.translation());
  for (int i = 0; i < model.dof(); ++i) {
    out.joints[static_cast<std::size_t>(i)] = {.position_rad = arm.q()[i],
                                               .velocity_rad_s = arm.qd()[i],
                                               .torque_nm = arm.torque()[i],
                                               .tool_lever_m = J.col(i).head<3>().norm()};
  }
  const Eigen::Matrix<double, 6, 1> twist_B = J * arm.qd();
  out.v_RT = X_RB.linear() * twist_B.head<3>();
  out.omega_RT = X_RB.linear() * twist_B.tail<3>();
}

api::GripperSnapshot gripper_readings(const physics::GripperState& gripper, double setting,
                                      double max_force_n) {
  return {.setting = setting,
          .separation_m = gripper.separation_m,
          .travel_m = gripper.travel_m,
          .force_n = gripper.force_n,
          .holding = gripper.holding,
          .held_body = gripper.held_body,
          .palm_deflection_m = gripper.palm_deflection_m,
          .max_force_n = max_force_n,
          .vacuum_pa = gripper.vacuum_pa};
}

void write_controller(const robot::RobotController& controller, api::RobotSnapshot& out) {
  out.trans_speed = controller.limit(api::MotionLimit::kTransSpeed);
  out.trans_accel = controller.limit(api::MotionLimit::kTransAccel);
  out.rot_speed = controller.limit(api::MotionLimit::kRotSpeed);
  out.rot_accel = controller.limit(api::MotionLimit::kRotAccel);
  out.override_fraction = controller.override_fraction();
  out.action = controller.status();
  out.X_RG = controller.X_RG();
  out.initialized = controller.initialized();
  out.protective_stop = controller.stopped_by_protection();
  controller.write(out.motion);
  out.moving = controller.moving();
  out.planning = controller.planning();
  out.planned_path = controller.path();
  out.drives_on = controller.drives_on();
}

}  // namespace aprsim::world
