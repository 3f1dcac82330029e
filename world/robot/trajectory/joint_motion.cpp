#include "world/robot/trajectory/joint_motion.hpp"

#include <algorithm>
#include <cmath>

// Point-to-point motion, synchronised where all joints start at rest: one double-S profile of the
// progress 0..1 within the limits of every joint.

namespace aprsim::robot {
namespace {

/// Limits of one joint, scaled in time.
ScalarLimits joint_scalar(const JointLimits& limits, int i, double scale) {
  return {limits.speed(i) * scale, limits.accel(i) * scale * scale,
          limits.jerk(i) * scale * scale * scale};
}

}  // namespace

bool JointMotion::has_consistent_sizes() const {
  const Eigen::Index n = end_.size();
  const auto fits = [n](const JointLimits& l) {
    return l.lower.size() == n && l.upper.size() == n && l.speed.size() == n &&
           l.accel.size() == n && l.jerk.size() == n && (l.lower.array() <= l.upper.array()).all();
  };
  return move_.start.size() == n && move_.target.size() == n && delta_.size() == n &&
         fits(move_.limits) && fits(move_.maximum);
}

void JointMotion::plan(const JointMove& move) {
  move_ = move;
  delta_ = move.target - move.start;
  speed_ = 1;
  braking_ = false;
  const bool moving = move.qd.size() > 0;
  if (moving) move_.independent.fill(true);
  plan_shared();
  for (int i = 0; i < delta_.size(); ++i) {
    if (!independent(i)) continue;
    const ScalarState start{move.start(i), moving ? move.qd(i) : 0, moving ? move.qdd(i) : 0};
    own(i) = DoubleS::to_rest(start, move.target(i), joint_scalar(move.limits, i, move.time_scale));
  }
  restart();
}

/// Limits of the progress: those of the tool and of each synchronised joint over its distance.
void JointMotion::plan_shared() {
  const double scale = move_.time_scale;
  ScalarLimits& l = shared_limits_;
  // Synchronised joints share one progress s(t): q = start + s delta, and the limits divided by
  // |delta_i| bound s', s'' and s''' (Biagiotti & Melchiorri 2008, ch. 5).
  l = {move_.progress_speed, move_.progress_accel, move_.progress_accel / kJerkTime_s};
  hard_limits_ = {1e9, 1e9, 1e9};
  bool moves = false;
  for (int i = 0; i < delta_.size(); ++i) {
    const double delta = std::abs(delta_(i));
    if (independent(i) || delta == 0) continue;
    moves = true;
    const ScalarLimits joint = joint_scalar(move_.limits, i, 1);
    l = {std::min(l.v, joint.v / delta), std::min(l.a, joint.a / delta),
         std::min(l.j, joint.j / delta)};
    hard_limits_.a = std::min(hard_limits_.a, move_.maximum.accel(i) / delta);
    hard_limits_.j = std::min(hard_limits_.j, move_.maximum.jerk(i) / delta);
  }
  // A hard stop has the unscaled limits.
  l = {l.v * scale, l.a * scale * scale, l.j * scale * scale * scale};
  any_synchronised_ = moves;
  shared_ = moves ? DoubleS::to_rest({0, 0, 0}, 1, l) : DoubleS();
}

void JointMotion::plan_stop(const JointVector& q, const JointVector& qd, const JointVector& qdd,
                            const JointLimits& limits) {
  move_ = {.start = q, .target = q, .limits = limits, .maximum = limits};
  move_.independent.fill(true);
  delta_ = JointVector::Zero(q.size());
  shared_ = DoubleS();
  speed_ = 1;
  braking_ = true;
  for (int i = 0; i < q.size(); ++i) {
    // Every joint stops on its own: the path is given up for the shortest time.
    own(i) = DoubleS::stop({q(i), qd(i), qdd(i)}, joint_scalar(limits, i, 1));
  }
  restart();
}

void JointMotion::brake(Brake how) {
  braking_ = true;
  shared_ = DoubleS::stop(shared_.at(time_), how == Brake::kHard ? hard_limits_ : shared_limits_);
  for (int i = 0; i < delta_.size(); ++i) {
    if (!independent(i)) continue;
    const ScalarLimits limits = how == Brake::kHard
                                    ? joint_scalar(move_.maximum, i, 1)
                                    : joint_scalar(move_.limits, i, move_.time_scale);
    own(i) = DoubleS::stop(own(i).at(time_), limits);
  }
  restart();
}

void JointMotion::set_speed(double fraction) {
  if (braking_ || fraction == speed_) return;
  speed_ = fraction;
  // A new profile from the present state: to the end, or to rest at fraction 0.
  const auto again = [&](const DoubleS& profile, double end, ScalarLimits limits) {
    if (profile.duration() == 0 && profile.end() == end)
      return profile;  // a joint that does not move
    // The override scales the speed only; accelerations stay, so that a change of override is
    // itself smooth.
    limits.v *= fraction;
    const ScalarState here = profile.at(time_);
    return fraction > 0 ? DoubleS::to_rest(here, end, limits) : DoubleS::stop(here, limits);
  };
  if (any_synchronised_) shared_ = again(shared_, 1, shared_limits_);
  for (int i = 0; i < delta_.size(); ++i) {
    if (!independent(i)) continue;
    own(i) = again(own(i), move_.target(i), joint_scalar(move_.limits, i, move_.time_scale));
  }
  restart();
}

/// The profiles begin now; their common end and duration.
void JointMotion::restart() {
  steps_ = 0;
  time_ = 0;
  duration_ = 0;
  end_ = move_.target;
  bool shared = false;
  for (int i = 0; i < delta_.size(); ++i) {
    if (independent(i)) {
      // A stop may end beyond a joint's range by its braking distance.
      end_(i) = std::clamp(own(i).end(), move_.limits.lower(i), move_.limits.upper(i));
      duration_ = std::max(duration_, own(i).duration());
    } else if (delta_(i) != 0) {
      shared = true;
      if (shared_.end() != 1) end_(i) = move_.start(i) + delta_(i) * shared_.end();
    }
  }
  if (shared) duration_ = std::max(duration_, shared_.duration());
}

void JointMotion::at(double t, JointVector& q) const {
  // Joints that have arrived are exactly at their end.
  q = end_;
  const bool shared_runs = t < shared_.duration();
  const double share = shared_.at(t).s;
  for (int i = 0; i < delta_.size(); ++i) {
    if (independent(i)) {
      if (t >= own(i).duration()) continue;
      q(i) = std::clamp(own(i).at(t).s, move_.limits.lower(i), move_.limits.upper(i));
    } else if (shared_runs) {
      q(i) = move_.start(i) + delta_(i) * share;
    }
  }
}

void JointMotion::sample(double interval_s, std::vector<JointVector>& out) const {
  for (double t = time_; t < duration_; t += interval_s) at(t, out.emplace_back());
  out.push_back(end_);
}

void JointMotion::remaining(std::size_t count, std::vector<JointVector>& out) const {
  for (std::size_t i = 0; i <= count; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(count);
    at(time_ + share * std::max(duration_ - time_, 0.0), out.emplace_back());
  }
  if (braking_ || speed_ > 0) return;
  // Held by the override: it will continue to its target.
  const JointVector held = out.back();
  for (std::size_t i = 1; i <= count; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(count);
    out.push_back(held + share * (move_.target - held));
  }
}

double JointMotion::deceleration_s() const {
  // From full speed: an acceleration that builds up and falls within its jerk limit.
  const ScalarLimits& l = shared_limits_;
  const double v = l.v * speed_;
  const double full = v * l.j >= l.a * l.a ? v / l.a + l.a / l.j : 2 * std::sqrt(v / l.j);
  return std::min(full, duration_ / 2);
}

double JointMotion::beyond_range() const {
  // A synchronised joint stays between its ends.
  constexpr int kSamples = 64;
  double beyond = 0;
  for (int i = 0; i < delta_.size(); ++i) {
    if (!independent(i)) continue;
    for (int k = 1; k < kSamples; ++k) {
      const double q = own(i).at(own(i).duration() * k / kSamples).s;
      beyond = std::max({beyond, move_.limits.lower(i) - q, q - move_.limits.upper(i)});
    }
  }
  return beyond;
}

bool JointMotion::advance(double dt, JointVector& q) {
  // Time from a count of steps: rounding does not add up.
  time_ = static_cast<double>(++steps_) * dt;
  at(time_, q);
  return time_ >= duration_ && (speed_ > 0 || braking_);
}

}  // namespace aprsim::robot
