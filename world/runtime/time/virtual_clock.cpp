#include "world/runtime/time/virtual_clock.hpp"

#include <algorithm>
#include <utility>

namespace aprsim::world {
namespace {

WallTime wall_now() { return std::chrono::steady_clock::now(); }

}  // namespace

VirtualClock::VirtualClock(VirtualTimeOptions options, SimTime step, std::function<void()> wake)
    : poll_period_(options.poll_period),
      step_(step),
      wake_(std::move(wake)),
      barrier_({std::move(options.pacers), options.grace}) {}

bool VirtualClock::is_registered(const std::string& role) const {
  const std::lock_guard lock(mutex_);
  return barrier_.is_registered(role);
}

std::optional<api::PacerId> VirtualClock::join(api::PacerRole role, std::function<void()> reached) {
  std::optional<api::PacerId> id;
  {
    const std::lock_guard lock(mutex_);
    const bool forwards_frames = role.kind == api::PacerKind::kFeed && role.robot >= 0;
    const int robot = role.robot;
    id = barrier_.join(std::move(role), wall_now());
    if (!id) return id;
    reached_[*id] = std::move(reached);
    if (forwards_frames) feeds_[*id] = {.robot = robot};
  }
  wake_();
  return id;
}

void VirtualClock::request_until(api::PacerId pacer, SimTime span) {
  {
    const std::lock_guard lock(mutex_);
    const auto steps = span.count() == 0 ? 0 : std::max<SimTime::rep>(1, span / step_);
    barrier_.request_until(pacer, static_cast<TimeBarrier::Steps>(steps));
    // Clients may have waited for this feed alone.
    release_reached(wall_now());
  }
  wake_();
}

void VirtualClock::finish(api::PacerId pacer) {
  const std::lock_guard lock(mutex_);
  barrier_.finish(pacer);
}

void VirtualClock::exclude(api::PacerId pacer) {
  {
    const std::lock_guard lock(mutex_);
    barrier_.exclude(pacer);
  }
  leave(pacer);
}

void VirtualClock::leave(api::PacerId pacer) {
  {
    const std::lock_guard lock(mutex_);
    barrier_.leave(pacer, wall_now());
    reached_.erase(pacer);
    feeds_.erase(pacer);
    release_reached(wall_now());
  }
  wake_();
}

VirtualClock::Turn VirtualClock::turn(WallTime now) {
  const std::lock_guard lock(mutex_);
  barrier_.expire(now);
  release_reached(now);
  Turn turn{barrier_.paced(), barrier_.due(), nullptr};
  // The state does not change while time runs.
  if (!state_ || !turn.paced || turn.due == 0) {
    api::VirtualTimeState state = barrier_.state(now);
    if (!state_ || state != *state_) {
      state_ = std::make_shared<const api::VirtualTimeState>(std::move(state));
    }
  }
  turn.state = state_;
  return turn;
}

void VirtualClock::set_robots(const std::vector<std::string>& robots, WallTime now) {
  const std::lock_guard lock(mutex_);
  barrier_.set_robots(robots, now);
  state_.reset();
}

std::vector<api::EndpointId> VirtualClock::endpoints() const {
  const std::lock_guard lock(mutex_);
  return barrier_.endpoints();
}

void VirtualClock::stepped() {
  const std::lock_guard lock(mutex_);
  barrier_.step();
  publishing_ = true;
}

bool VirtualClock::published(const api::Snapshot& snapshot, WallTime now) {
  const std::lock_guard lock(mutex_);
  publishing_ = false;
  for (auto& [id, feed] : feeds_) {
    // Its listener closes where a reset has removed the robot.
    if (static_cast<std::size_t>(feed.robot) >= snapshot.robots.size()) continue;
    const auto& frame = snapshot.robots[static_cast<std::size_t>(feed.robot)].vision;
    if (frame.number == feed.number && snapshot.epoch == feed.epoch) continue;
    feed.number = frame.number;
    feed.epoch = snapshot.epoch;
    barrier_.cut(id);
  }
  release_reached(now);
  return !barrier_.paced() || barrier_.due() > 0;
}

void VirtualClock::release_clients(WallTime now) {
  const std::lock_guard lock(mutex_);
  notify(barrier_.release_clients(now));
}

void VirtualClock::release_reached(WallTime now) {
  if (!publishing_) notify(barrier_.take_reached(now));
}

void VirtualClock::notify(const std::vector<api::PacerId>& reached) {
  for (const api::PacerId id : reached) {
    const auto found = reached_.find(id);
    if (found != reached_.end()) found->second();
  }
}

}  // namespace aprsim::world
