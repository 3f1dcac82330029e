#include "server/replay/sample_times.hpp"

#include <algorithm>
#include <cmath>

#include "world/base/time.hpp"

namespace aprsim::server {

bool SampleTimes::is_due(const world::World& world, world::RunTime time) {
  const double now_s = seconds(world.time()), step_s = seconds(world.step_size());
  if (time.epoch != epoch_) base_s_ = latest_s_ - now_s;
  epoch_ = time.epoch;
  latest_s_ = std::max(latest_s_, base_s_ + now_s);
  const auto step = static_cast<std::uint64_t>(std::llround(latest_s_ / step_s));
  // The function is also called after commands.
  if (step < next_step_) return false;
  next_step_ = step + steps_between(world);
  return latest_s_ >= options_.from_s && latest_s_ <= options_.to_s;
}

double SampleTimes::rate_hz(const world::World& world) const {
  return 1 / (static_cast<double>(steps_between(world)) * seconds(world.step_size()));
}

std::uint64_t SampleTimes::steps_between(const world::World& world) const {
  const double step_s = seconds(world.step_size());
  return static_cast<std::uint64_t>(
      std::max(1LL, std::llround(1 / (std::max(options_.rate_hz, 1e-6) * step_s))));
}

}  // namespace aprsim::server
