#include "world/robot/trajectory/profile/double_s.hpp"

#include <algorithm>
#include <cmath>

// Double-S profile: Biagiotti & Melchiorri 2008, sec. 3.4. Deviations: any initial velocity and
// acceleration, as in online trajectory generation (Kroeger & Wahl 2010), and the cruise speed of a
// way too short for the speed limit by bisection instead of case distinctions.

namespace aprsim::robot {
namespace {

/// Constant jerk for a time.
struct Piece {
  double dt = 0, jerk = 0;
};

/// Time-optimal pieces from (v, a) to (v_end, 0).
struct SpeedChange {
  std::array<Piece, 4> pieces{};
  int count = 0;
  void add(double dt, double jerk) {
    if (dt > 0) pieces[static_cast<std::size_t>(count++)] = {dt, jerk};
  }
};

SpeedChange speed_change(double v, double a, double v_end, const ScalarLimits& limits) {
  SpeedChange out;
  const double j = limits.j;
  // Back within the acceleration limit first.
  if (std::abs(a) > limits.a) {
    const double dt = (std::abs(a) - limits.a) / j;
    const double jerk = -std::copysign(j, a);
    v += a * dt + jerk * dt * dt / 2;
    a = std::copysign(limits.a, a);
    out.add(dt, jerk);
  }
  // Mirrored so that the acceleration's peak is positive.
  // v + a |a| / (2 j) is the speed that remains if the acceleration is only taken back to zero. It
  // decides the direction of the first jerk phase.
  const double sigma = v_end >= v + a * std::abs(a) / (2 * j) ? 1.0 : -1.0;
  const double dv = sigma * (v_end - v);
  a *= sigma;
  // Jerk phases up to the peak acceleration and back to 0, and between them constant acceleration
  // where its limit is reached.
  // Without a plateau the peak follows from dv = (2 peak^2 - a^2) / (2 j).
  const double peak = std::min(limits.a, std::sqrt(std::max(0.0, j * dv + a * a / 2)));
  const double hold = peak > 0 ? (dv - (2 * peak * peak - a * a) / (2 * j)) / peak : 0.0;
  out.add((peak - a) / j, sigma * j);
  out.add(hold, 0);
  out.add(peak / j, -sigma * j);
  return out;
}

ScalarState integrate(const ScalarState& x, double jerk, double t) {
  return {x.s + t * (x.v + t * (x.a / 2 + t * jerk / 6)), x.v + t * (x.a + t * jerk / 2),
          x.a + t * jerk};
}

/// Distance from `start` over cruise speed `v` to rest, without cruise phase.
double distance_over(const ScalarState& start, double v, const ScalarLimits& limits) {
  ScalarState x{0, start.v, start.a};
  const auto up = speed_change(start.v, start.a, v, limits);
  for (int i = 0; i < up.count; ++i) {
    const auto& piece = up.pieces[static_cast<std::size_t>(i)];
    x = integrate(x, piece.jerk, piece.dt);
  }
  // From (v, 0) to rest the speed falls symmetrically about v / 2.
  const double speed = std::abs(v);
  const double ramp = limits.a * limits.a / limits.j;
  const double time =
      speed >= ramp ? speed / limits.a + limits.a / limits.j : 2 * std::sqrt(speed / limits.j);
  return x.s + v * time / 2;
}

/// Cruise speed with which the distance without cruise phase is `distance`.
double cruise_speed(const ScalarState& start, double distance, const ScalarLimits& limits) {
  // Bracket: the highest, because the distance is not monotone in the speed for a moving start.
  constexpr int kScan = 16;
  double high = limits.v;
  double low = -limits.v;
  for (int i = 1; i < kScan; ++i) {
    const double v = limits.v * (1 - 2.0 * i / kScan);
    if (distance_over(start, v, limits) <= distance) {
      low = v;
      break;
    }
    high = v;
  }
  // Bisection to the last bit.
  for (int i = 0; i < 100; ++i) {
    const double mid = low + (high - low) / 2;
    if (mid <= low || mid >= high) break;
    (distance_over(start, mid, limits) <= distance ? low : high) = mid;
  }
  return low;
}

}  // namespace

void DoubleS::add(double dt, double jerk, ScalarState& state) {
  if (!(dt > 0) || count_ == kMaxPhases) return;
  phases_[static_cast<std::size_t>(count_++)] = {duration_, jerk, state};
  duration_ += dt;
  state = integrate(state, jerk, dt);
}

void DoubleS::change_speed(double v_end, const ScalarLimits& limits, ScalarState& state) {
  const auto change = speed_change(state.v, state.a, v_end, limits);
  for (int i = 0; i < change.count; ++i) {
    const auto& piece = change.pieces[static_cast<std::size_t>(i)];
    add(piece.dt, piece.jerk, state);
  }
  // Exactly at the end speed, without rounding.
  if (change.count > 0) state = {state.s, v_end, 0};
}

DoubleS DoubleS::to_rest(const ScalarState& start, double s_end, const ScalarLimits& limits) {
  DoubleS plan;
  plan.end_ = s_end;
  ScalarState state = start;
  const double distance = s_end - start.s;
  if (distance == 0 && start.v == 0 && start.a == 0) return plan;
  // With a cruise phase at full speed in either direction, else without one.
  const double forward = distance_over(start, limits.v, limits);
  const double backward = distance_over(start, -limits.v, limits);
  double cruise = 0;
  double time = 0;
  if (distance >= forward) {
    cruise = limits.v;
    time = (distance - forward) / limits.v;
  } else if (distance <= backward) {
    cruise = -limits.v;
    time = (backward - distance) / limits.v;
  } else {
    cruise = cruise_speed(start, distance, limits);
  }
  plan.change_speed(cruise, limits, state);
  plan.add(time, 0, state);
  plan.change_speed(0, limits, state);
  return plan;
}

DoubleS DoubleS::stop(const ScalarState& start, const ScalarLimits& limits) {
  DoubleS plan;
  ScalarState state = start;
  plan.change_speed(0, limits, state);
  plan.end_ = state.s;
  return plan;
}

ScalarState DoubleS::at(double t) const {
  if (!(t < duration_)) return {end_, 0, 0};
  int i = count_ - 1;
  while (i > 0 && phases_[static_cast<std::size_t>(i)].begin > t) --i;
  const auto& phase = phases_[static_cast<std::size_t>(i)];
  return integrate(phase.state, phase.jerk, std::max(0.0, t - phase.begin));
}

}  // namespace aprsim::robot
