#pragma once

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "world/robot/controller/robot_controller.hpp"
#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/trajectory/profile/joint_limits.hpp"

namespace aprsim::robot {

/// A controller of one of the shipped arms, stepped by hand, with everything it gave recorded.
class ControllerRig {
 public:
  /// `arm`: "fanuc", "motoman", "ur5e", "irb120", "panda" or "scara".
  explicit ControllerRig(const std::string& arm);
  explicit ControllerRig(ControllerSetup setup);

  const ArmModel& model() const { return setup_.model; }
  const ControllerSetup& setup() const { return setup_; }
  const JointLimits& limits() const { return limits_; }
  RobotController& controller() { return controller_; }
  int dof() const { return setup_.model.dof(); }

  void apply(const api::RobotAction& action) {
    controller_.apply(++ticket_, action, controller_.reference());
  }
  api::Ticket ticket() const { return ticket_; }
  api::ActionState state() const { return controller_.status().state; }
  const std::string& reason() const { return controller_.status().description; }

  void step(bool gripper_settled = true);
  void steps(int count) {
    for (int i = 0; i < count; ++i) step();
  }
  /// A step with external torques on the joints [Nm].
  void load(const JointVector& external_nm) {
    path_.push_back(controller_.step({.external_nm = external_nm}));
  }
  /// Applies the command and steps until it is done or failed; at most `limit_s` simulated seconds.
  api::ActionState run(const api::RobotAction& action, double limit_s = 120);
  /// Initialises the robot, moves it to a posture with room all round and forgets the way there.
  void ready();
  /// Steps until nothing moves any more.
  void rest(double limit_s = 30);

  /// Forgets what was recorded, but for the present reference.
  void forget() { path_.assign(1, controller_.reference()); }
  const std::vector<JointVector>& path() const { return path_; }

  Eigen::Isometry3d X_RT(const JointVector& q) const;
  Pose tool() const { return Pose::from(X_RT(controller_.reference())); }
  JointVector random_posture(std::mt19937& engine, double margin = 0) const;
  /// A command that a client might send at any time.
  api::RobotAction random_command(std::mt19937& engine) const;

  /// Highest share of the joint speed, acceleration and jerk limits that the recorded references
  /// take.
  struct Effort {
    double speed = 0, accel = 0, jerk = 0;
    double tool_speed = 0, tool_accel = 0, tool_turn = 0;
  };
  Effort effort() const;

 private:
  ControllerSetup setup_;
  JointLimits limits_;
  RobotController controller_;
  api::Ticket ticket_ = 0;
  std::vector<JointVector> path_;
};

ControllerSetup rig_setup(const std::string& arm);
api::MoveJoints move_all(const JointVector& q);

inline double degrees(double rad) { return rad * 180 / 3.14159265358979323846; }
inline double radians(double deg) { return deg * 3.14159265358979323846 / 180; }

}  // namespace aprsim::robot
