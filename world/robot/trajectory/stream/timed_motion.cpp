#include "world/robot/trajectory/stream/timed_motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace aprsim::robot {
namespace {

constexpr double kRestSpeed_rad_s = 1e-3;  ///< below it a joint counts as at rest
constexpr double kRampShare = 0.5;         ///< of the joints' accelerations, for a change of rate
constexpr double kShortestRamp_s = 0.02;   ///< of the rate from 0 to 1

constexpr SimTime kShortestRest = std::chrono::milliseconds(1);  ///< of a motion that is cut

/// A point on the curve between two, such that the curve to it is the same.
CurvePoint point_between(const CurvePoint& from, const CurvePoint& to, SimTime time) {
  const JointCurve curve(from, to);
  const JointState state = curve.at(seconds(time - from.time));
  CurvePoint point{time, state.q};
  if (curve.degree() >= 3) point.qd = state.qd;
  if (curve.degree() == 5) point.qdd = state.qdd;
  return point;
}

}  // namespace

void TimedMotion::begin(const JointVector& q) {
  clear();
  const JointVector rest = JointVector::Zero(q.size());
  from_ = {SimTime(0), q, rest, rest};
  // It starts at full rate: its first motion is from rest in any case.
  rate_ = 1;
}

void TimedMotion::append(std::shared_ptr<const PointBlock> block, const JointVector& q) {
  const bool stands = !running();
  if (stands) {
    from_ = tail(q);
    time_ = from_.time;
    rest_ns_ = 0;
  }
  left_ += block->points.size();
  end_time_ = block->points.back().time;
  blocks_.push_back(std::move(block));
  if (stands) curve_ = JointCurve(from_, target());
}

void TimedMotion::end_at(SimTime time) {
  time = std::max(time, time_ + kShortestRest);
  if (!running() || time >= end_time_) return;
  auto kept = std::make_shared<PointBlock>();
  CurvePoint from = from_;
  std::size_t skipped = next_;
  for (const auto& block : blocks_) {
    for (std::size_t i = std::exchange(skipped, 0); i < block->points.size(); ++i) {
      const CurvePoint& to = block->points[i];
      if (from.time >= time) break;
      kept->points.push_back(to.time <= time ? to : point_between(from, to, time));
      from = kept->points.back();
    }
  }
  left_ = kept->points.size();
  next_ = 0;
  blocks_ = {std::move(kept)};
  end_time_ = time;
  curve_ = JointCurve(from_, target());
}

CurvePoint TimedMotion::tail(const JointVector& q) const {
  if (running()) return blocks_.back()->points.back();
  const JointVector rest = JointVector::Zero(q.size());
  return {end_time_, q, rest, rest};
}

void TimedMotion::clear() {
  blocks_.clear();
  next_ = 0;
  left_ = 0;
  curve_ = {};
  from_.time = time_ = end_time_ = SimTime(0);
  rest_ns_ = 0;
}

const JointVector& TimedMotion::end() const {
  return running() ? blocks_.back()->points.back().q : from_.q;
}

bool TimedMotion::ends_moving() const {
  return from_.qd.size() > 0 && from_.qd.cwiseAbs().maxCoeff() > kRestSpeed_rad_s;
}

double TimedMotion::curve_time() const {
  return (static_cast<double>((time_ - from_.time).count()) + rest_ns_) * 1e-9;
}

/// Time-scaled motion q(s(t)) has the acceleration q'' s'^2 + q' s'': the second term bounds the
/// change of the rate by the joints' accelerations.
void TimedMotion::pass_time(const StepInput& input) {
  const double step_ns = std::round(input.step_s * 1e9);
  if (rate_ != input.speed) {
    const JointVector qd = curve_.at(std::min(curve_time(), curve_.duration())).qd;
    double change = 1 / kShortestRamp_s;
    for (Eigen::Index i = 0; i < qd.size(); ++i) {
      const double accel = kRampShare * input.limits.accel(i);
      if (std::abs(qd(i)) * change > accel) change = accel / std::abs(qd(i));
    }
    const double most = change * input.step_s;
    rate_ += std::clamp(input.speed - rate_, -most, most);
  }
  const double passed = rest_ns_ + rate_ * step_ns;
  const double whole = std::floor(passed);
  time_ += SimTime(static_cast<SimTime::rep>(whole));
  rest_ns_ = passed - whole;
}

bool TimedMotion::advance(const StepInput& input, JointVector& q) {
  if (!running()) return false;
  pass_time(input);
  while (running() && time_ >= target().time) reach_target();
  if (running()) {
    q = curve_.at(curve_time()).q;
  } else {
    q = from_.q;
    // Points that end at a speed within the step: the rest of it goes on at that speed.
    if (ends_moving()) q += from_.qd * curve_time();
    time_ = from_.time;
    rest_ns_ = 0;
  }
  return running();
}

/// The next curve begins at the present one's end.
void TimedMotion::reach_target() {
  from_ = target();
  --left_;
  ++done_;
  if (++next_ == blocks_.front()->points.size()) {
    blocks_.erase(blocks_.begin());
    next_ = 0;
  }
  curve_ = running() ? JointCurve(from_, target()) : JointCurve();
}

std::uint64_t TimedMotion::count_points() const {
  std::uint64_t count = 0;
  for (const auto& block : blocks_) {
    if (!block) return left_ + 1;
    count += block->points.size();
  }
  return count >= next_ && (blocks_.empty() || next_ < blocks_.front()->points.size())
             ? count - next_
             : left_ + 1;
}

bool TimedMotion::is_ascending() const {
  SimTime last = from_.time;
  std::size_t skipped = next_;
  for (const auto& block : blocks_) {
    for (const CurvePoint& point : block->points) {
      if (skipped > 0) {
        --skipped;
        continue;
      }
      if (point.time <= last) return false;
      last = point.time;
    }
  }
  return true;
}

void TimedMotion::list(SharedParts& parts) const {
  for (const auto& block : blocks_) parts[block.get()] = sizeof *block + bytes_of(block->points);
}

}  // namespace aprsim::robot
