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

std::int64_t MotomanQueue::time_left_ms(const api::Snapshot& now) const {
  const std::int64_t whole = end_ms_ - origin_ms_;
  if (whole == 0 || begins_ || now.applied < begun_) return whole;
  const auto passed = std::chrono::floor<std::chrono::milliseconds>(link_.robot(now).motion.time);
  return std::max<std::int64_t>(whole - passed.count(), 0);
}

bool MotomanQueue::is_cutting(const api::Snapshot& now) const {
  return !waiting_.empty() || time_left_ms(now) > kIncrements * clock_.count();
}

std::optional<SimTime> MotomanQueue::drop_uncut(const api::Snapshot& now) {
  if (!waiting_.empty()) {
    clear();
    return std::nullopt;
  }
  const std::int64_t left = time_left_ms(now), queued = kIncrements * clock_.count();
  if (left <= queued) return std::nullopt;
  end_ms_ -= left - queued;
  return std::chrono::milliseconds(end_ms_ - origin_ms_);
}

std::int64_t MotomanQueue::count(const api::Snapshot& now) const {
  const std::int64_t clock = clock_.count();
  return std::min(kIncrements, (time_left_ms(now) + clock - 1) / clock);
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
