#include "protocols/simple_message/motoman_queue.hpp"

#include <algorithm>
#include <utility>

#include "protocols/ports/command_failure.hpp"

namespace aprsim::simple_message {

void MotomanQueue::begin_stream(api::Ticket stream) {
  stream_ = stream;
  begin(0);
  begun_ = latest_ = stream;
}

void MotomanQueue::begin(std::int64_t time_ms) {
  origin_ms_ = end_ms_ = time_ms;
  begins_ = true;
  handed_.clear();
  waiting_.clear();
  off_clock_ms_.clear();
}

void MotomanQueue::clear() { begin(end_ms_); }

bool MotomanQueue::stands(const api::Snapshot& now) const {
  const api::MotionSnapshot& motion = link_.robot(now).motion;
  return now.applied >= latest_ && motion.stream == stream_ &&
         motion.phase == api::StreamPhase::kReady;
}

/// A trajectory that has run dry in mid-motion takes no points while the robot brakes.
bool MotomanQueue::takes_points(const api::Snapshot& now) const {
  if (begins_) return stands(now);
  return now.applied < latest_ || link_.robot(now).motion.phase != api::StreamPhase::kStopping;
}

/// Points that came while the robot braked were refused, and wait until it stands.
void MotomanQueue::check_handed(const api::Snapshot& now) {
  while (!handed_.empty() && handed_.front().first <= now.applied) {
    const Error* const failure = protocols::failure_of(now, handed_.front().first);
    if (failure != nullptr && failure->code == ErrorCode::kFailedPrecondition) {
      waiting_.push_back(std::move(handed_.front().second));
    }
    handed_.pop_front();
  }
}

std::int64_t MotomanQueue::passed_ms(const api::Snapshot& now) const {
  if (begins_ || now.applied < begun_) return 0;
  const auto passed = std::chrono::floor<std::chrono::milliseconds>(link_.robot(now).motion.time);
  return std::min<std::int64_t>(passed.count(), whole_ms());
}

/// One increment ends at each tick of the clock, and one at each point between two ticks.
std::int64_t MotomanQueue::increments(std::int64_t from_ms, std::int64_t to_ms) const {
  const std::int64_t clock = clock_.count();
  const auto points = std::ranges::count_if(
      off_clock_ms_, [&](std::int64_t point) { return point > from_ms && point <= to_ms; });
  return to_ms / clock - from_ms / clock + points;
}

/// When the queue is full, if its first increment begins then.
std::int64_t MotomanQueue::full_at_ms(std::int64_t from_ms) const {
  const std::int64_t clock = clock_.count();
  const auto tick_after = [clock](std::int64_t time) { return (time / clock + 1) * clock; };
  std::int64_t time = from_ms;
  for (std::int64_t i = 0; i < kIncrements; ++i) {
    const std::int64_t tick = tick_after(time);
    const auto point = std::ranges::upper_bound(off_clock_ms_, time);
    time = point == off_clock_ms_.end() ? tick : std::min(tick, *point);
  }
  return time;
}

bool MotomanQueue::is_cutting(const api::Snapshot& now) const {
  return !waiting_.empty() || increments(passed_ms(now), whole_ms()) > kIncrements;
}

std::optional<SimTime> MotomanQueue::drop_uncut(const api::Snapshot& now) {
  if (!waiting_.empty()) {
    clear();
    return std::nullopt;
  }
  if (!is_cutting(now)) return std::nullopt;
  const std::int64_t end_ms = full_at_ms(passed_ms(now));
  std::erase_if(off_clock_ms_, [end_ms](std::int64_t point) { return point > end_ms; });
  end_ms_ = origin_ms_ + end_ms;
  return std::chrono::milliseconds(end_ms);
}

std::int64_t MotomanQueue::count(const api::Snapshot& now) const {
  return std::min(kIncrements, increments(passed_ms(now), whole_ms()));
}

Result<void> MotomanQueue::add(std::int64_t time_ms, JointVector position_rad,
                               JointVector velocity_rad_s) {
  if (time_ms <= end_ms_) return {};
  const api::SnapshotPtr now = link_.latest();
  check_handed(*now);
  Point point{time_ms - origin_ms_, std::move(position_rad), std::move(velocity_rad_s)};
  if (!waiting_.empty() || !takes_points(*now)) {
    waiting_.push_back(std::move(point));
  } else if (auto added = append(begins_, std::move(point)); !added) {
    return added;
  }
  end_ms_ = time_ms;
  if (whole_ms() % clock_.count() != 0) off_clock_ms_.push_back(whole_ms());
  return {};
}

Result<void> MotomanQueue::append(bool begins, Point point) {
  const auto ticket = link_.submit(api::AppendPoints{
      stream_,
      begins,
      {{std::chrono::milliseconds(point.time_ms), point.position_rad, point.velocity_rad_s, {}}}});
  if (!ticket) return tl::unexpected(ticket.error());
  latest_ = *ticket;
  handed_.emplace_back(*ticket, std::move(point));
  if (begins) begun_ = *ticket;
  begins_ = false;
  return {};
}

void MotomanQueue::advance(const api::Snapshot& now) {
  check_handed(now);
  while (!waiting_.empty() && takes_points(now)) {
    if (!append(begins_, waiting_.front())) return;
    waiting_.erase(waiting_.begin());
  }
}

}  // namespace aprsim::simple_message
