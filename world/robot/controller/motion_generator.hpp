#pragma once

#include "world/robot/controller/equipped_arm.hpp"
#include "world/robot/controller/retreat_trail.hpp"
#include "world/robot/controller/torque_mode.hpp"
#include "world/robot/planning/plan_job.hpp"
#include "world/robot/servo/drive_power.hpp"
#include "world/robot/trajectory/motion_runner.hpp"
#include "world/robot/trajectory/stream/move_chain.hpp"
#include "world/robot/trajectory/stream/timed_motion.hpp"

namespace aprsim::robot {

/// Generates the arm's joint reference: runs planned motions, brakes them, adds the joints in
/// torque mode, and retreats after a collision. A copyable value; copies share the plans. Thread:
/// sim.
///
/// A streamed motion runs while no other does; every stop drops its points.
///
/// Moves of joints and free moves of the tool are blended from the motion that runs; the others
/// begin where it comes to rest on its own path.
class MotionGenerator {
 public:
  /// At rest at `q`.
  explicit MotionGenerator(const JointVector& q) : runner_(q), joint_targets_(q) {}

  /// One step; reference() is that of its end. `external_nm`: contact torques on the joints, empty
  /// = none. `planning`: another motion is to come, so the drives stay on. Does not allocate.
  void step(const EquippedArm& arm, const JointVector& external_nm, bool planning);

  // ---- motions

  /// The request for a plan from the present motion. Ends torque mode at once, because the motion
  /// of a joint in it cannot be predicted.
  [[nodiscard]] PlanRequest request_plan(const EquippedArm& arm, MoveRequest move);
  /// Whether the reference and its rest are as the plan expects them.
  [[nodiscard]] bool is_as_expected(const EquippedArm& arm, const Plan& plan) const;
  /// Begins the planned motion of `move`; switches the drives on.
  void begin(const EquippedArm& arm, const PlannedMove& move, const Plan& plan);
  /// Moves straight in joint space from `from` to the newest posture of the trail that is far
  /// enough.
  void retreat(const EquippedArm& arm, const JointVector& from);

  // ---- a streamed motion

  /// Begins one without points, at rest; switches the drives on. Ends torque mode.
  void begin_stream(const EquippedArm& arm, api::StreamMode mode);
  /// Forgets it; it must be at rest or stopped before.
  void end_stream() { stream_ = std::monostate(); }
  /// Slows it down on its path to a stand, or continues.
  void pause_stream(bool paused) { stream_paused_ = paused; }
  [[nodiscard]] bool stream_paused() const { return stream_paused_; }
  /// The streamed motion of that kind; null = there is none.
  [[nodiscard]] TimedMotion* timed() { return std::get_if<TimedMotion>(&stream_); }
  [[nodiscard]] const TimedMotion* timed() const { return std::get_if<TimedMotion>(&stream_); }
  [[nodiscard]] MoveChain* chain() { return std::get_if<MoveChain>(&stream_); }
  /// Points that it has not reached, and that it has.
  [[nodiscard]] std::uint64_t stream_left() const;
  [[nodiscard]] std::uint64_t stream_done() const;

  // ---- stops

  /// Brakes on the path and drops the next motion.
  void brake(const EquippedArm& arm, Brake how);
  /// The fastest stop of all joints, from `q` at the reference's velocity. `q` is the reference or
  /// the arm's actual posture.
  void stop_from(const EquippedArm& arm, const JointVector& q);
  /// The reference is `q`, at rest.
  void set_at_rest(const JointVector& q);

  // ---- settings

  /// Speed override 0..1; `next_only` leaves the running motion alone.
  void set_override(double fraction, bool next_only);
  /// Share 0..1 of the speed that the override leaves.
  void set_speed_share(double share, bool next_only);
  /// Brakes that were engaged take their time to release.
  void switch_drives_on(double step_s);
  void switch_drives_off_after(int steps) { drives_.switch_off_after(steps); }
  void keep_drives_on() { drives_.cancel_switch_off(); }

  // ---- state

  [[nodiscard]] const JointVector& reference() const { return runner_.reference(); }
  /// Before the last step.
  [[nodiscard]] const JointVector& last_reference() const { return runner_.last_reference(); }
  /// No motion runs or is to run, except joints in torque mode.
  [[nodiscard]] bool idle() const { return runner_.idle(); }
  [[nodiscard]] bool at_rest() const {
    return runner_.idle() && !torque_mode_busy() && !stream_moves();
  }
  /// Posture where the last of the motions ends; only while not idle.
  [[nodiscard]] const JointVector& end() const { return runner_.end(); }
  /// Adds the reference and positions on the way that is left, `count` for each motion; of a
  /// streamed motion the reference alone.
  void remaining(std::size_t count, std::vector<JointVector>& out) const {
    runner_.remaining(count, out);
  }
  [[nodiscard]] bool retreating() const { return retreating_ && runner_.running(); }
  [[nodiscard]] double override_fraction() const { return override_; }
  [[nodiscard]] const DrivePower& drives() const { return drives_; }
  /// A joint in torque mode that is held before its target; -1 = none.
  [[nodiscard]] int balanced_joint() const {
    return torque_mode_.active() ? torque_mode_.balanced_joint() : -1;
  }
  [[nodiscard]] JointVector applied_torque(int dof) const {
    return torque_mode_.applied_torque(dof);
  }
  /// Adds what copies share: the plans of motions.
  void list(SharedParts& parts) const {
    runner_.list(parts);
    if (const TimedMotion* points = timed()) points->list(parts);
  }
  /// Memory besides the value itself and what copies share.
  [[nodiscard]] std::size_t bytes() const;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [runner, joint_targets, to_joint_targets, torque_mode, torque_mode_pending, trail, drives,
           override_fraction, speed_share, retreating, stream, stream_paused] = self;
    io(runner, joint_targets, to_joint_targets, torque_mode, torque_mode_pending, trail, drives,
       override_fraction, speed_share, retreating, stream, stream_paused);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.all_joints(joint_targets_.size());
    in.require(override_ >= 0 && override_ <= 1 && speed_share_ >= 0 && speed_share_ <= 1,
               "a speed override beyond 0 to 1");
  }

 private:
  /// Share of full speed of every motion.
  [[nodiscard]] double speed() const { return speed_share_ * override_; }
  /// A joint in torque mode has not settled yet.
  [[nodiscard]] bool torque_mode_busy() const {
    return torque_mode_.active() && !torque_mode_.settled();
  }
  void start_torque_mode(const EquippedArm& arm, const api::MoveJoints& move, const Plan& plan);
  void advance_torque_mode(const EquippedArm& arm, const JointVector& external_nm);
  void advance_stream(const EquippedArm& arm);
  void drop_points();
  /// It has points left and does not stand paused.
  [[nodiscard]] bool stream_moves() const {
    return stream_left() > 0 && !(stream_paused_ && reference() == last_reference());
  }

  MotionRunner runner_;
  JointVector joint_targets_;
  bool to_joint_targets_ = false;  ///< the running motion goes to joint_targets_
  TorqueMode torque_mode_;
  bool torque_mode_pending_ = false;  ///< until the other joints are at rest
  RetreatTrail trail_;
  DrivePower drives_;
  double override_ = 1, speed_share_ = 1;
  bool retreating_ = false;  ///< the running motion is the retreat of a protective stop
  std::variant<std::monostate, TimedMotion, MoveChain> stream_;
  bool stream_paused_ = false;
};

}  // namespace aprsim::robot
