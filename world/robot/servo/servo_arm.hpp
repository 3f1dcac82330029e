#pragma once

#include <span>
#include <string>

#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/model/arm_model.hpp"

namespace aprsim::robot {

/// Servo parameters of the deviation dynamics; the defaults are estimates of a stiff industrial
/// servo (velocity loop inside a position loop).
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
/// A trip changes nothing by itself: the caller stops the motion on trip_reason(). No call but the
/// constructor allocates. Thread: sim.
class ServoArm {
 public:
  /// All that changes while an arm runs: a copy that is restored later continues bit for bit.
  struct State {
    JointVector q_ref, qd_ref;    ///< where the reference is and how fast
    JointVector e, ed, integral;  ///< deviation, its speed, integrated speed error
    bool deviating = false;
    int disturbed_steps = 0;  ///< in a row above the trip torque
    JointVector q, qd, torque;
    JointVector applied;  ///< torques that joints in torque mode apply
    JointVector limit;    ///< highest torques of the drives
    bool braked = false;  ///< drives off, brakes on
    Payload payload;
    std::string trip_reason;

    /// See world/archive/archive.hpp.
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [q_ref, qd_ref, e, ed, integral, deviating, disturbed_steps, q, qd, torque, applied,
             limit, braked, payload, trip_reason] = self;
      io(q_ref, qd_ref, e, ed, integral, deviating, disturbed_steps, q, qd, torque, applied, limit,
         braked, payload, trip_reason);
    }
    template <typename In>
    void require_valid(In& in) const {
      for (const JointVector* each :
           {&q_ref, &qd_ref, &e, &ed, &integral, &q, &qd, &torque, &applied, &limit}) {
        in.all_joints(each->size());
      }
    }
  };

  /// `step_s` <= 2 ms keeps the default gains stable. Joint 0 is next to the base.
  ServoArm(ArmModel model, Payload payload, const Eigen::Vector3d& gravity_B,
           const JointVector& q_start, double step_s, ServoParameters servo = {});

  /// Advances one step to the reference `q_ref_next`, with external joint torques `tau_ext`
  /// (J^T w of all contact wrenches on links and tool) as they are at its start. `tau_load` is
  /// the part of them that bodies on the tool exert, such as the weight of a held part. Friction
  /// keeps it from moving the arm, like any other torque, but the drives bear all of it. Empty:
  /// none.
  void step(const JointVector& q_ref_next, const JointVector& tau_ext,
            const JointVector& tau_load = {});

  /// Adds position and velocity of the deviation to the reference: the next reference must start
  /// from q(). The arm keeps its momentum: where the next reference has another velocity, the
  /// drives change it within their limits. Used after a trip and by InitRobot, so that a loaded
  /// arm does not snap back.
  void relax();
  /// Clears the trip; the deviation stays.
  void clear_trip();

  /// From the next step on.
  void set_payload(const Payload& payload);

  /// Torques that joints in torque mode apply to their load [Nm], >= 0: no cause for a trip.
  void set_applied_torque(const JointVector& torque_nm) { s_.applied = torque_nm; }

  /// From the next step on: share of each drive's highest torque that it can give, above 0.
  void set_torque_share(std::span<const double> share);

  /// From the next step on: whether the brakes hold the arm under any load, with the drives off.
  void set_braked(bool braked) { s_.braked = braked; }

  [[nodiscard]] const State& state() const { return s_; }
  void restore(const State& state);

  [[nodiscard]] const ArmModel& model() const { return model_; }
  [[nodiscard]] const JointVector& q() const { return s_.q; }            ///< actual position
  [[nodiscard]] const JointVector& qd() const { return s_.qd; }          ///< actual velocity
  [[nodiscard]] const JointVector& torque() const { return s_.torque; }  ///< of the drives [Nm]
  /// Not empty once a trip condition held: names joint, value and limit. Cleared by relax()
  /// and clear_trip().
  [[nodiscard]] const std::string& trip_reason() const { return s_.trip_reason; }

 private:
  [[nodiscard]] JointVector beyond_friction(const JointVector& tau_ext) const;
  void add_held_load(const JointVector& tau_load);
  [[nodiscard]] JointVector return_speed(const JointMatrix& H) const;
  void step_braked(const JointVector& q_ref_next);
  void deviate(const JointVector& feedforward, const JointVector& disturbance);
  void check_trip(const JointVector& feedforward);
  void trip(int joint, const char* what, double value, double limit, const char* unit);

  ArmModel model_;
  Eigen::Vector3d gravity_B_;
  double step_s_;
  ServoParameters servo_;
  JointVector max_torque_, max_speed_;

  State s_;
};

}  // namespace aprsim::robot
