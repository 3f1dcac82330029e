#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "world/robot/trajectory/joint_motion.hpp"
#include "world/robot/trajectory/profile/joint_limits.hpp"
#include "world/robot/trajectory/profile/shared_parts.hpp"

namespace aprsim::robot {

/// A move of all joints to a posture, on a straight line in joint space.
struct ChainedMove {
  JointVector target;
  double speed = 1;     ///< share of the joints' speeds, in (0, 1]
  double rounding = 0;  ///< share 0..1 of its deceleration that the next move overlaps

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [target, speed, rounding] = self;
    io(target, speed, rounding);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.all_joints(target.size());
    in.require(speed > 0 && speed <= 1 && rounding >= 0 && rounding <= 1,
               "a move with a share beyond 0 to 1");
  }
};

/// Executes moves one after the other. Where the present move decelerates, the next one is added
/// to it: the corner between them is rounded and both lines are kept elsewhere. The sum stays
/// within the joints' limits; the overlap begins later where it would not. A copyable value; a
/// step does not allocate. Thread: sim.
class MoveChain {
 public:
  /// The move follows those that wait. Allocates.
  void append(const ChainedMove& move) { waiting_.push_back(move); }

  struct StepInput {
    const JointLimits& limits;
    double speed = 1;  ///< override, 0..1
    double step_s = 1e-3;
  };
  /// One step from the present reference `q`: writes the next. Returns whether moves are left.
  bool advance(const StepInput& input, JointVector& q);
  /// Drops all moves.
  void clear();

  [[nodiscard]] bool running() const { return running_ || !waiting_.empty(); }
  /// Moves that are not reached, the present one included.
  [[nodiscard]] std::uint64_t left() const {
    return waiting_.size() + (running_ ? 1U : 0U) + (overlaps_ ? 1U : 0U);
  }
  /// Moves after the present one, also one that overlaps it.
  [[nodiscard]] std::size_t waiting() const { return waiting_.size() + (overlaps_ ? 1U : 0U); }
  [[nodiscard]] std::uint64_t done() const { return done_; }
  /// Target of the last move; `q` if there is none.
  [[nodiscard]] const JointVector& end(const JointVector& q) const;

  /// Memory besides the value itself.
  [[nodiscard]] std::size_t bytes() const { return bytes_of(waiting_); }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [present, next, rounding, next_rounding, speed, running, overlaps, waiting, done] = self;
    io(present, next, rounding, next_rounding, speed, running, overlaps, waiting, done);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(!running_ || present_.is_planned(), "a move that is not planned");
    in.require(!overlaps_ || (running_ && next_.is_planned()), "an overlap without two moves");
    in.require(rounding_ >= 0 && rounding_ <= 1 && speed_ >= 0 && speed_ <= 1,
               "a move with a share beyond 0 to 1");
  }

 private:
  [[nodiscard]] JointMotion planned(const ChainedMove& move, const JointVector& from,
                                    const StepInput& input) const;
  [[nodiscard]] ChainedMove take_waiting();
  void begin_next(const StepInput& input, const JointVector& q);
  void try_overlap(const StepInput& input);
  [[nodiscard]] bool sum_is_within(const StepInput& input, const JointMotion& next) const;
  void apply_speed(double speed);

  JointMotion present_, next_;
  double rounding_ = 0, next_rounding_ = 0;
  double speed_ = 1;  ///< override that the motions have
  bool running_ = false, overlaps_ = false;
  std::vector<ChainedMove> waiting_;
  std::uint64_t done_ = 0;
};

}  // namespace aprsim::robot
