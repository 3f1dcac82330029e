#include "world/runtime/health.hpp"

#include <chrono>
#include <cstdio>

namespace aprsim::world {
namespace {

using std::chrono::nanoseconds;

/// Durations after which something is a problem: no turn of the thread, a pace below kLeastPace of
/// its target, more than kMostBacklog of the queue full.
constexpr nanoseconds kStuck = std::chrono::seconds(1);
constexpr nanoseconds kSlow = std::chrono::seconds(3);
constexpr nanoseconds kBacklog = std::chrono::seconds(1);
constexpr double kLeastPace = 0.9, kMostBacklog = 0.5;
/// A backlog ends when it has not been seen for so long: a flood may pause for single turns.
constexpr nanoseconds kBacklogPause = std::chrono::milliseconds(200);

std::int64_t ns(WallTime time) { return nanoseconds(time.time_since_epoch()).count(); }

void track(std::atomic<std::int64_t>& since, bool is_problem, std::int64_t now) {
  if (!is_problem) {
    since = 0;
  } else if (since == 0) {
    since = now;
  }
}

/// Whether a problem that began at `since` (0 = none) has lasted for longer than `limit`.
bool lasts(std::int64_t since, std::int64_t now, nanoseconds limit) {
  return since != 0 && now - since > limit.count();
}

double seconds_between(std::int64_t since, std::int64_t now) {
  return static_cast<double>(now - since) * 1e-9;
}

}  // namespace

Health::Health(std::size_t queue_capacity)
    : backlog_limit_(static_cast<std::size_t>(kMostBacklog * static_cast<double>(queue_capacity))) {
}

void Health::record_turn(WallTime wall_now, const Load& load) {
  const std::int64_t now = ns(wall_now);
  last_turn_ns_ = now;
  if (load.waiting_commands > backlog_limit_) backlog_seen_ns_ = now;
  track(backlog_since_ns_, backlog_seen_ns_ != 0 && now - backlog_seen_ns_ < kBacklogPause.count(),
        now);
  track(slow_since_ns_, load.speed && load.pace > 0 && load.pace < kLeastPace * *load.speed, now);
}

void Health::end() {
  last_turn_ns_ = 0;
  backlog_since_ns_ = 0;
}

bool Health::makes_progress(WallTime now) const { return !lasts(last_turn_ns_, ns(now), kStuck); }

std::string Health::problem(WallTime wall_now, const api::Snapshot& snapshot) const {
  if (!snapshot.world_fault.empty()) {
    return "the simulation has stopped until the cell is reset: " + snapshot.world_fault;
  }
  const std::int64_t now = ns(wall_now), turn = last_turn_ns_, slow = slow_since_ns_,
                     backlog = backlog_since_ns_;
  char text[120] = "";
  if (lasts(turn, now, kStuck)) {
    std::snprintf(text, sizeof text, "the simulation has made no progress for %.1f s",
                  seconds_between(turn, now));
  } else if (lasts(backlog, now, kBacklog)) {
    std::snprintf(text, sizeof text, "more than %zu commands have been waiting for %.1f s",
                  backlog_limit_, seconds_between(backlog, now));
  } else if (lasts(slow, now, kSlow)) {
    std::snprintf(text, sizeof text, "the pace is %.2f instead of %g", snapshot.real_time_factor,
                  snapshot.speed_target.value_or(0));
  }
  return text;
}

}  // namespace aprsim::world
