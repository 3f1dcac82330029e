#include "server/replay/replay_pace.hpp"

#include <memory>
#include <thread>

namespace aprsim::server::journal {
namespace {

constexpr std::chrono::milliseconds kLate{100};

}  // namespace

std::chrono::steady_clock::time_point ReplayPace::due(const world::World& world,
                                                      world::RunTime time) {
  using SteadyClock = std::chrono::steady_clock;
  const auto now = SteadyClock::now();
  const bool next = last_ && last_->epoch == time.epoch && time.step == last_->step + 1;
  const bool same = last_ && *last_ == time;
  last_ = time;
  if (!speed_) return now;
  if (next) {
    due_ += std::chrono::duration_cast<SteadyClock::duration>(world.step_size() / *speed_);
  }
  if ((!next && !same) || now - due_ > kLate) due_ = now;
  return due_;
}

Replay::Watch paced(double speed) {
  const auto pace = std::make_shared<ReplayPace>(speed);
  return [pace](const world::World& world, world::RunTime time) {
    std::this_thread::sleep_until(pace->due(world, time));
    return true;
  };
}

}  // namespace aprsim::server::journal
