#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "world/base/time.hpp"
#include "world/robot/trajectory/profile/joint_limits.hpp"
#include "world/robot/trajectory/profile/shared_parts.hpp"
#include "world/robot/trajectory/stream/joint_curve.hpp"

namespace aprsim::robot {

/// Points that were accepted together; copies of a motion share them.
struct PointBlock {
  std::vector<CurvePoint> points;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [points] = self;
    io(points);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(!points.empty(), "a block without points");
  }
};

/// A motion along points at their times, which may be appended while it runs. Between the points
/// it follows JointCurve at every step. Its time passes at the speed override's rate, stands
/// without points, and changes its rate within the joints' accelerations. A copyable value; a step
/// does not allocate. Thread: sim.
class TimedMotion {
 public:
  /// A trajectory from `q` at rest, whose time begins now. Drops the points that are left.
  void begin(const JointVector& q);
  /// The points follow those that are left, with increasing times. Without points the motion goes
  /// on from `q`, where the robot stands.
  void append(std::shared_ptr<const PointBlock> block, const JointVector& q);
  /// Drops the points after this time and ends the curve there, a millisecond from now at the
  /// earliest. No effect on a motion that ends before. Allocates.
  void end_at(SimTime time);
  /// Where the points that are left end: the first point of the next curve.
  [[nodiscard]] CurvePoint tail(const JointVector& q) const;

  struct StepInput {
    const JointLimits& limits;
    double speed = 1;  ///< wanted rate of the time, 0..1
    double step_s = 1e-3;
  };
  /// One step: writes the position. Returns whether it has points left.
  bool advance(const StepInput& input, JointVector& q);
  /// Drops the points; the next ones begin a trajectory.
  void clear();

  [[nodiscard]] bool running() const { return left_ > 0; }
  [[nodiscard]] std::uint64_t left() const { return left_; }
  [[nodiscard]] std::uint64_t done() const { return done_; }
  [[nodiscard]] SimTime time() const { return time_; }
  /// Time of the last point that was accepted.
  [[nodiscard]] SimTime end_time() const { return end_time_; }
  /// Rate of the time, 0..1.
  [[nodiscard]] double rate() const { return rate_; }
  /// Where the latest trajectory ends.
  [[nodiscard]] const JointVector& end() const;
  /// Whether the point that was reached last has a speed.
  [[nodiscard]] bool ends_moving() const;

  /// Memory besides the value itself and the blocks, which copies share.
  [[nodiscard]] std::size_t bytes() const { return bytes_of(blocks_); }
  /// Adds the blocks.
  void list(SharedParts& parts) const;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [blocks, next, left, done, curve, from, time, rest_ns, rate, end_time] = self;
    io(blocks, next, left, done, curve, from, time, rest_ns, rate, end_time);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(left_ == count_points(), "another number of points than a trajectory has");
    in.require(rate_ >= 0 && rate_ <= 1 && rest_ns_ >= 0 && rest_ns_ < 1, "a rate beyond 0 to 1");
    in.require(left_ == 0 || curve_.degree() > 0, "a trajectory without a curve");
    in.require(is_ascending(), "times of a trajectory that do not increase");
    in.require(left_ == 0 || (time_ >= from_.time && time_ < target().time),
               "a time beyond the present curve");
    if (left_ > 0) in.all_joints(from_.q.size());
  }

 private:
  [[nodiscard]] const CurvePoint& target() const { return blocks_.front()->points[next_]; }
  [[nodiscard]] std::uint64_t count_points() const;
  [[nodiscard]] bool is_ascending() const;
  void pass_time(const StepInput& input);
  void reach_target();
  [[nodiscard]] double curve_time() const;

  std::vector<std::shared_ptr<const PointBlock>> blocks_;
  std::size_t next_ = 0;  ///< in the first block: the end of the curve
  std::uint64_t left_ = 0, done_ = 0;
  JointCurve curve_;  ///< the present one
  CurvePoint from_;   ///< its begin
  // Whole nanoseconds: at full rate no rounding adds up.
  SimTime time_{};
  double rest_ns_ = 0;  ///< fraction of a nanosecond, beside time_
  double rate_ = 0;
  SimTime end_time_{};
};

}  // namespace aprsim::robot
