#include "world/runtime/time/pacer.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::world {
namespace {

/// Lateness that is caught up in bursts; beyond it steps are dropped.
constexpr std::chrono::milliseconds kMaxLateness{50};
/// Steps between two polls of the command queue.
constexpr std::int64_t kBurst = 5;
constexpr std::chrono::milliseconds kWindow{1000};
/// The first window is shorter, so that figures exist soon after the start.
constexpr std::chrono::milliseconds kFirstWindow{100};

}  // namespace

Pacer::Pacer(std::chrono::nanoseconds step, WallTime now)
    : step_(step), origin_(now), window_start_(now) {}

void Pacer::set_speed(std::optional<double> factor, WallTime now) {
  factor_ = factor;
  restart(now);
}

void Pacer::restart(WallTime now) {
  origin_ = now;
  counted_ = 0;
}

int Pacer::due(WallTime now) {
  if (!factor_) return 1;
  const double wall_step_ns = static_cast<double>(step_.count()) / *factor_;
  const auto behind = static_cast<std::int64_t>(
      std::floor(static_cast<double>((now - origin_).count()) / wall_step_ns) -
      static_cast<double>(counted_));
  if (behind <= 0) return 0;
  const auto most = std::max(
      kBurst,
      static_cast<std::int64_t>(
          static_cast<double>(std::chrono::nanoseconds(kMaxLateness).count()) / wall_step_ns));
  if (behind > most) {
    const auto given_up = static_cast<std::uint64_t>(behind - kBurst);
    missed_ += given_up;
    counted_ += given_up;
  }
  return static_cast<int>(std::min(behind, kBurst));
}

WallTime Pacer::next(WallTime now) const {
  if (!factor_) return now;
  const double wall_step_ns = static_cast<double>(step_.count()) / *factor_;
  return origin_ + std::chrono::nanoseconds(static_cast<std::int64_t>(
                       std::ceil(static_cast<double>(counted_ + 1) * wall_step_ns)));
}

void Pacer::stepped(WallTime now, std::chrono::nanoseconds cost) {
  ++counted_;
  ++window_steps_;
  window_cost_ += cost;
  measure(now);
}

void Pacer::measure(WallTime now) {
  const auto span = now - window_start_;
  if (span < (step_time_s_ > 0 ? kWindow : kFirstWindow)) return;
  real_time_factor_ = static_cast<double>(window_steps_) * static_cast<double>(step_.count()) /
                      static_cast<double>(std::chrono::nanoseconds(span).count());
  if (window_steps_ > 0) {
    step_time_s_ =
        std::chrono::duration<double>(window_cost_).count() / static_cast<double>(window_steps_);
  }
  window_start_ = now;
  window_steps_ = 0;
  window_cost_ = {};
}

}  // namespace aprsim::world
