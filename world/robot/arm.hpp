#pragma once

#include <span>
#include <string>
#include <vector>

#include "world/robot/arm_model.hpp"
#include "world/robot/dynamics.hpp"

namespace aprsim::robot {

/// Servo parameters of the deviation dynamics; defaults are ARMS estimates of a stiff industrial
/// servo.
struct ServoParameters {
  double velocity_gain_1_s = 300;
  double position_gain_1_s = 40;
  double integral_gain_1_s = 10;
  double friction_fraction = 0.04;   ///< deadband of external torque, of max torque
  double trip_fraction = 0.3;        ///< of max torque: disturbance that trips
  double trip_deviation_rad = 0.02;  ///< deviation that trips
};

/// A servo-driven arm: joint state = reference + deviation. With nothing touching and torques
/// within limits the arm is its reference, bit for bit; an external torque beyond friction or a
/// torque limit wakes the deviation, which yields, saturates, trips and returns to exactly zero.
/// Thread: sim.
class Arm {
 public:
  Arm(ArmModel model, Payload payload, const Eigen::Vector3d& gravity_B, const JointVector& q_start,
      double step_s, ServoParameters servo = {});

  /// Advances one step to the reference `q_ref_next`, with external joint torques `tau_ext`
  /// (J^T w of all contact wrenches on links and tool, grip excluded).
  void step(const JointVector& q_ref_next, const JointVector& tau_ext);

  /// Takes the deviation into the reference: the next reference must start from q(). Used after a
  /// trip and by InitRobot, so that a pressed arm does not snap back.
  void relax();

  void set_payload(const Payload& payload);

  [[nodiscard]] const ArmModel& model() const;
  [[nodiscard]] const JointVector& q() const;       ///< actual position
  [[nodiscard]] const JointVector& qd() const;      ///< actual velocity
  [[nodiscard]] const JointVector& torque() const;  ///< of the drives [Nm]
  [[nodiscard]] bool deviating() const;
  /// Not empty once a trip condition held: names joint, value and limit. Cleared by relax().
  [[nodiscard]] const std::string& trip_reason() const;
};

}  // namespace aprsim::robot
