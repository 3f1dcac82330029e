#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/world/robot/controller/controller_rig.hpp"
#include "world/api/snapshot/motion_snapshot.hpp"

namespace aprsim::robot {

/// A rig whose controller takes streams.
class StreamRig : public ControllerRig {
 public:
  using ControllerRig::ControllerRig;

  /// The command's error; empty = it was carried out.
  std::string send(const api::TrajectoryAction& action, std::int64_t delay = 0) {
    const auto done = controller().apply(++number, action, delay, controller().reference());
    return done ? "" : done.error().message;
  }
  std::string claim(api::StreamMode mode = api::StreamMode::kTimed, bool reset = false) {
    std::string error = send(api::ClaimMotion{"tester", mode, reset});
    if (error.empty()) stream = number;
    return error;
  }
  api::MotionSnapshot motion() {
    api::MotionSnapshot out;
    controller().write(out);
    return out;
  }
  api::StreamEnd last_end() {
    const auto ends = motion().ends;
    return ends && !ends->empty() ? ends->back() : api::StreamEnd{};
  }
  /// Steps until the stream has no points left, or has ended.
  void finish(int limit = 60000) {
    for (int i = 0; i < limit; ++i) {
      const auto now = motion();
      if (now.phase == api::StreamPhase::kReady || now.phase == api::StreamPhase::kNone) return;
      step();
    }
  }

  api::Ticket number = 1000, stream = 0;
};

inline std::vector<double> values_of(const JointVector& q) {
  return {q.data(), q.data() + q.size()};
}

inline SimTime time_of_seconds(double seconds) {
  return SimTime(static_cast<SimTime::rep>(std::llround(seconds * 1e9)));
}

/// Points on smooth curves about the present posture, from rest to rest: each joint is
/// a (1 - cos w t) with w and a drawn, sampled each `period`. Within `share` of the speed and
/// acceleration limits.
inline std::vector<api::TrajectoryPoint> smooth_points(StreamRig& rig, std::mt19937& engine,
                                                       int count, double period, double share,
                                                       bool accelerations) {
  const int n = rig.dof();
  const JointVector start = rig.controller().reference();
  const double T = count * period;
  JointVector amplitude(n), frequency(n);
  for (int i = 0; i < n; ++i) {
    // Whole periods, so that it ends at rest.
    const int turns = std::uniform_int_distribution(1, 2)(engine);
    frequency(i) = 2 * M_PI * turns / T;
    const double w = frequency(i);
    const double room =
        std::min(rig.limits().upper(i) - start(i), start(i) - rig.limits().lower(i));
    double a = std::min(
        {share * rig.limits().speed(i) / w, share * rig.limits().accel(i) / (w * w), room / 2.5});
    a *= std::uniform_real_distribution(0.3, 1.0)(engine);
    amplitude(i) = std::uniform_int_distribution(0, 1)(engine) ? a : -a;
  }
  std::vector<api::TrajectoryPoint> points;
  for (int k = 1; k <= count; ++k) {
    const double t = k * period;
    JointVector q(n), qd(n), qdd(n);
    for (int i = 0; i < n; ++i) {
      const double w = frequency(i), a = amplitude(i);
      q(i) = start(i) + a * (1 - std::cos(w * t));
      qd(i) = k == count ? 0 : a * w * std::sin(w * t);
      qdd(i) = a * w * w * std::cos(w * t);
    }
    points.push_back({time_of_seconds(t), values_of(q), values_of(qd), {}});
    if (accelerations) points.back().acceleration_rad_s2 = values_of(qdd);
  }
  return points;
}

}  // namespace aprsim::robot
