#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "world/api/commands/trajectory_command.hpp"
#include "world/api/snapshot/motion_snapshot.hpp"
#include "world/base/result.hpp"
#include "world/robot/controller/equipped_arm.hpp"
#include "world/robot/controller/motion_generator.hpp"
#include "world/robot/controller/stream_goal.hpp"
#include "world/robot/trajectory/stream/timed_motion.hpp"

namespace aprsim::robot {

/// The stream that has the robot, its goal, and the ends of the latest streams. Its motion itself
/// is MotionGenerator's. A copyable value; a step allocates only where a stream ends. Thread: sim.
class MotionStream {
 public:
  /// What it moves.
  struct Arm {
    const EquippedArm& equipped;
    const Eigen::Vector3d& gravity_B;
    MotionGenerator& motion;
  };

  // ---- commands. Errors as in world/api/commands/trajectory_command.hpp.

  /// The robot is free, at rest and without an alarm.
  void claim(api::Ticket ticket, const api::ClaimMotion& command, const Arm& arm);
  [[nodiscard]] Result<void> apply(const api::AppendPoints& command, const Arm& arm);
  [[nodiscard]] Result<void> apply(const api::AppendMove& command, const Arm& arm);
  [[nodiscard]] Result<void> apply(const api::StopStream& command, const Arm& arm);
  [[nodiscard]] Result<void> apply(const api::PauseStream& command, const Arm& arm);
  [[nodiscard]] Result<void> apply(const api::ReleaseMotion& command, const Arm& arm);
  /// The robot is free, at rest and without an alarm. `delay`: steps until the start, negative for
  /// one that has passed.
  [[nodiscard]] Result<void> follow(api::Ticket ticket, const api::FollowTrajectory& command,
                                    std::int64_t delay, const Arm& arm);

  // ---- one step

  /// Before the motion's step: starts and ends, and the tolerances against the state that the last
  /// step has led to. Empty vectors: the arm is at the reference.
  void step(const JointVector& q_actual, const JointVector& qd_actual, const Arm& arm);

  // ---- ends

  /// The robot has been stopped: the stream, if any, has ended. The caller stops the motion.
  void stopped(const std::string& why, MotionGenerator& motion);
  /// No motion until clear_alarm().
  void set_alarm(const std::string& why) { alarm_ = why; }
  void clear_alarm() { alarm_.clear(); }

  // ---- state

  [[nodiscard]] bool active() const { return number_ != 0; }
  [[nodiscard]] api::Ticket number() const { return number_; }
  [[nodiscard]] const std::string& commander() const { return commander_; }
  /// Empty = none.
  [[nodiscard]] const std::string& alarm() const { return alarm_; }
  /// Writes all but the source of a robot without a stream.
  void write(const MotionGenerator& motion, double step_s, api::MotionSnapshot& out) const;

  /// Memory besides the value itself and the points, which copies share.
  [[nodiscard]] std::size_t bytes() const;
  /// Adds the points of a trajectory that waits for its start.
  void list(SharedParts& parts) const;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [number, commander, release_when_done, goal, delayed, ends, alarm] = self;
    io(number, commander, release_when_done, goal, delayed, ends, alarm);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(commander_.size() <= api::kMaxCommanderName, "a commander with a long name");
    in.require(!ends_ || ends_->size() <= api::kMaxStreamEnds,
               "more ends of streams than are kept");
    in.require(active() || (!goal_.active && !delayed_), "a goal without a stream");
  }

 private:
  [[nodiscard]] Result<void> require_number(api::Ticket stream) const;
  void begin(api::Ticket ticket, const std::string& commander);
  void end(api::StreamResult result, std::string text, MotionGenerator& motion);
  /// Stops the robot and ends the stream.
  void halt(api::StreamResult result, std::string text, const Arm& arm);
  void report(api::Ticket stream, api::StreamResult result, std::string text);
  [[nodiscard]] tl::unexpected<Error> raise_alarm(const Error& error, const Arm& arm);
  [[nodiscard]] Result<void> begin_goal(const api::FollowTrajectory& command,
                                        std::shared_ptr<const PointBlock> block, const Arm& arm);
  void start_delayed(const Arm& arm);
  void check_goal(const TrackingState& state, const Arm& arm);
  [[nodiscard]] api::StreamPhase phase(const MotionGenerator& motion) const;

  api::Ticket number_ = 0;  ///< 0 = no stream
  std::string commander_;
  bool release_when_done_ = false;
  StreamGoal goal_;
  std::shared_ptr<const PointBlock> delayed_;  ///< until the goal's start
  SharedList<api::StreamEnd> ends_;
  std::string alarm_;
};

}  // namespace aprsim::robot
