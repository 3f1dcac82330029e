#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace aprsim::world {

using WallTime = std::chrono::steady_clock::time_point;

/// Decides how many steps are due by the wall clock, and measures what was reached. The clock is
/// passed in. Overload drops steps and counts them. Steps are never lengthened, and catching up
/// is bounded. Thread: sim.
class Pacer {
 public:
  Pacer(std::chrono::nanoseconds step, WallTime now);

  /// Target ratio of simulated to wall time; nullopt = as fast as possible.
  void set_speed(std::optional<double> factor, WallTime now);
  /// Discards the time that passed while the cell was not stepped.
  void restart(WallTime now);

  /// Steps to take now, at most a short burst.
  [[nodiscard]] int due(WallTime now);
  /// When the next step is due (now, when as fast as possible).
  [[nodiscard]] WallTime next(WallTime now) const;

  /// Call after each step with the wall time it took.
  void stepped(WallTime now, std::chrono::nanoseconds cost);
  /// Call regularly also without steps, so that the measurement decays.
  void measure(WallTime now);

  [[nodiscard]] std::optional<double> speed() const { return factor_; }
  [[nodiscard]] double real_time_factor() const { return real_time_factor_; }
  [[nodiscard]] double step_time_s() const { return step_time_s_; }
  [[nodiscard]] std::uint64_t missed_steps() const { return missed_; }

 private:
  std::chrono::nanoseconds step_;
  std::optional<double> factor_ = 1.0;
  WallTime origin_;            ///< when step number 0 of this count was due
  std::uint64_t counted_ = 0;  ///< steps taken or dropped since origin_
  std::uint64_t missed_ = 0;
  WallTime window_start_;
  std::uint64_t window_steps_ = 0;
  std::chrono::nanoseconds window_cost_{};
  double real_time_factor_ = 0;
  double step_time_s_ = 0;
};

}  // namespace aprsim::world
