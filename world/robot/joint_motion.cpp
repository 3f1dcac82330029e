#include "world/robot/joint_motion.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::robot {
namespace {

ScalarLimits joint_scalar(const JointLimits& limits, int i, double pace) {
  return {limits.speed(i) * pace, limits.accel(i) * pace * pace,
          limits.jerk(i) * pace * pace * pace};
}

}  // namespace

void JointMotion::plan(const JointMove& move) {
  move_ = move;
  way_ = move.target - move.start;
  steps_ = 0;
  time_ = 0;
  plan_shared();
  for (int i = 0; i < way_.size(); ++i) {
    if (!move_.alone[static_cast<std::size_t>(i)]) continue;
    own(i) = DoubleS::to_rest({move.start(i), 0, 0}, move.target(i),
                              joint_scalar(move.limits, i, move.pace));
  }
  find_end();
}

void JointMotion::plan_shared() {
  const double pace = move_.pace;
  ScalarLimits& l = shared_limits_;
  l = {move_.share_speed, move_.share_accel, move_.share_accel / kJerkTime_s};
  hard_limits_ = {1e9, 1e9, 1e9};
  bool moves = false;
  for (int i = 0; i < way_.size(); ++i) {
    const double way = std::abs(way_(i));
    if (move_.alone[static_cast<std::size_t>(i)] || way == 0) continue;
    moves = true;
    const ScalarLimits joint = joint_scalar(move_.limits, i, 1);
    l = {std::min(l.v, joint.v / way), std::min(l.a, joint.a / way), std::min(l.j, joint.j / way)};
    hard_limits_.a = std::min(hard_limits_.a, move_.maximum.accel(i) / way);
    hard_limits_.j = std::min(hard_limits_.j, move_.maximum.jerk(i) / way);
  }
  l = {l.v * pace, l.a * pace * pace, l.j * pace * pace * pace};
  shared_ = moves ? DoubleS::to_rest({0, 0, 0}, 1, l) : DoubleS();
}

void JointMotion::plan_stop(const JointVector& q, const JointVector& qd, const JointVector& qdd,
                            const JointLimits& limits) {
  move_ = {.start = q, .target = q, .limits = limits, .maximum = limits};
  move_.alone.fill(true);
  way_ = JointVector::Zero(q.size());
  shared_ = DoubleS();
  steps_ = 0;
  time_ = 0;
  for (int i = 0; i < q.size(); ++i) {
    own(i) = DoubleS::stop({q(i), qd(i), qdd(i)}, joint_scalar(limits, i, 1));
  }
  find_end();
}

void JointMotion::brake(Brake how) {
  shared_ = DoubleS::stop(shared_.at(time_), how == Brake::kHard ? hard_limits_ : shared_limits_);
  for (int i = 0; i < way_.size(); ++i) {
    if (!move_.alone[static_cast<std::size_t>(i)]) continue;
    const ScalarLimits limits = how == Brake::kHard ? joint_scalar(move_.maximum, i, 1)
                                                    : joint_scalar(move_.limits, i, move_.pace);
    own(i) = DoubleS::stop(own(i).at(time_), limits);
  }
  steps_ = 0;
  time_ = 0;
  find_end();
}

void JointMotion::find_end() {
  duration_ = 0;
  end_ = move_.target;
  bool shared = false;
  for (int i = 0; i < way_.size(); ++i) {
    if (move_.alone[static_cast<std::size_t>(i)]) {
      end_(i) = std::clamp(own(i).end(), move_.limits.lower(i), move_.limits.upper(i));
      duration_ = std::max(duration_, own(i).duration());
    } else if (way_(i) != 0) {
      shared = true;
      if (shared_.end() != 1) end_(i) = move_.start(i) + way_(i) * shared_.end();
    }
  }
  if (shared) duration_ = std::max(duration_, shared_.duration());
}

void JointMotion::at(double t, JointVector& q) const {
  q = end_;
  const bool shared_runs = t < shared_.duration();
  const double share = shared_.at(t).s;
  for (int i = 0; i < way_.size(); ++i) {
    if (move_.alone[static_cast<std::size_t>(i)]) {
      if (t >= own(i).duration()) continue;
      q(i) = std::clamp(own(i).at(t).s, move_.limits.lower(i), move_.limits.upper(i));
    } else if (shared_runs) {
      q(i) = move_.start(i) + way_(i) * share;
    }
  }
}

bool JointMotion::advance(double dt, JointVector& q) {
  time_ = static_cast<double>(++steps_) * dt;
  at(time_, q);
  return time_ >= duration_;
}

}  // namespace aprsim::robot
