#include "world/runtime/history/history_records.hpp"

#include <algorithm>
#include <new>
#include <utility>
#include <variant>

namespace aprsim::world {
namespace {

/// Memory of a segment and of a command, besides the state and the waypoints; approximately.
constexpr std::uint64_t kSegmentBytes = 256, kCommandBytes = 512;
/// Bounds the list when a cell is reset continually.
constexpr std::size_t kMaxSegments = 4000;
/// Only whole segments are dropped, so the commands of one segment get this part of the memory.
constexpr std::uint64_t kMinSegments = 8;

/// Memory of points and of commands, approximately.
std::uint64_t bytes_of(const std::vector<api::TrajectoryPoint>& points) {
  std::uint64_t bytes = 0;
  for (const api::TrajectoryPoint& point : points) {
    bytes += sizeof point +
             sizeof(double) * (point.position_rad.capacity() + point.velocity_rad_s.capacity() +
                               point.acceleration_rad_s2.capacity());
  }
  return bytes;
}

std::uint64_t bytes_of(const api::TrajectoryCommand& command) {
  if (const auto* append = std::get_if<api::AppendPoints>(&command.action)) {
    return bytes_of(append->points);
  }
  const auto* follow = std::get_if<api::FollowTrajectory>(&command.action);
  return follow ? bytes_of(follow->points) : 0;
}

std::uint64_t bytes_of(const api::Command& command) {
  if (const auto* stream = std::get_if<api::TrajectoryCommand>(&command.body)) {
    return kCommandBytes + bytes_of(*stream);
  }
  const auto* robot = std::get_if<api::RobotCommand>(&command.body);
  const auto* through = robot ? std::get_if<api::MoveThroughTo>(&robot->action) : nullptr;
  return kCommandBytes + (through ? through->waypoints.capacity() * sizeof(api::Waypoint) : 0);
}

}  // namespace

void HistoryRecords::began(RunTime time, std::uint64_t seed, const std::string* loaded,
                           const std::shared_ptr<const scene::Scene>&) {
  const std::lock_guard lock(mutex_);
  epochs_[time.epoch] = {seed, loaded == nullptr ? std::nullopt : std::optional(*loaded)};
}

void HistoryRecords::applied(RunTime time, const QueuedCommand& command, const Error*) {
  const std::lock_guard lock(mutex_);
  grow(time);
  // The effect of a simulation command is in the epochs and states.
  if (std::holds_alternative<api::SimulationCommand>(command.command.body)) return;
  if (segments_.empty() || segments_.back().begin.epoch != time.epoch) return;
  try {
    segments_.back().commands.push_back(
        std::make_shared<const PastCommand>(PastCommand{time, command}));
    const std::uint64_t bytes = bytes_of(command.command);
    Segment& segment = segments_.back();
    const std::uint64_t state = segment.bytes - segment.command_bytes;
    segment.bytes += bytes;
    segment.command_bytes += bytes;
    bytes_ += bytes;
    const std::uint64_t most = std::max(limits_.bytes / kMinSegments, state);
    if (segment.command_bytes > most) wants_checkpoint_ = true;
  } catch (const std::bad_alloc&) {
    // The past after a lost command cannot be computed.
    segments_.clear();
    bytes_ = 0;
    wants_checkpoint_ = true;
  }
}

void HistoryRecords::sampled(RunTime time, StateSample) {
  const std::lock_guard lock(mutex_);
  grow(time);
  if (segments_.empty() || time.step - segments_.back().begin.step >= limits_.checkpoint_steps) {
    wants_checkpoint_ = true;
  }
}

void HistoryRecords::saved(RunTime time, std::uint64_t, std::shared_ptr<const WorldState> state) {
  wants_checkpoint_ = false;
  const std::uint64_t bytes = state->bytes() + kSegmentBytes;
  const std::lock_guard lock(mutex_);
  grow(time);
  Segment next{time, std::move(state), {}, time.step, 0, bytes, 0};
  if (!segments_.empty()) {
    const Segment& last = segments_.back();
    next.position = last.position + (last.last_step - last.begin.step);
  }
  segments_.push_back(std::move(next));
  bytes_ += bytes;
  trim();
}

void HistoryRecords::stopped(RunTime time, const std::string&) { reach(time); }

void HistoryRecords::reach(RunTime time) {
  const std::lock_guard lock(mutex_);
  grow(time);
}

void HistoryRecords::drop_older_half() {
  std::vector<Segment> dropped;  // freed without the lock
  const std::lock_guard lock(mutex_);
  const std::size_t half = segments_.size() / 2;
  dropped.reserve(half);
  for (std::size_t i = 0; i < half; ++i) {
    bytes_ -= segments_.front().bytes;
    dropped.push_back(std::move(segments_.front()));
    segments_.pop_front();
  }
}

void HistoryRecords::grow(RunTime time) {
  if (segments_.empty()) return;
  Segment& last = segments_.back();
  if (last.begin.epoch == time.epoch) last.last_step = std::max(last.last_step, time.step);
}

void HistoryRecords::trim() {
  const std::uint64_t now = segments_.back().position;
  while (segments_.size() > 1 && (now - segments_[1].position > limits_.steps ||
                                  bytes_ > limits_.bytes || segments_.size() > kMaxSegments)) {
    bytes_ -= segments_.front().bytes;
    segments_.pop_front();
  }
  while (epochs_.begin()->first < segments_.front().begin.epoch) epochs_.erase(epochs_.begin());
}

std::vector<api::HistorySpan> HistoryRecords::spans() const {
  const std::lock_guard lock(mutex_);
  std::vector<api::HistorySpan> spans;
  for (const Segment& segment : segments_) {
    if (spans.empty() || spans.back().epoch != segment.begin.epoch) {
      api::HistorySpan& span = spans.emplace_back();
      span.epoch = segment.begin.epoch;
      span.first_step = segment.begin.step;
      if (const auto epoch = epochs_.find(span.epoch); epoch != epochs_.end()) {
        span.seed = epoch->second.seed;
        span.loaded_state = epoch->second.loaded;
      }
    }
    spans.back().last_step = segment.last_step;
  }
  return spans;
}

const HistoryRecords::Segment* HistoryRecords::find(api::Moment moment) const {
  // The last segment that begins at or before the moment.
  const auto after = std::ranges::upper_bound(segments_, moment, {}, [](const Segment& segment) {
    return api::Moment{segment.begin.epoch, segment.begin.step};
  });
  if (after == segments_.begin()) return nullptr;
  const Segment& found = *std::prev(after);
  const bool there = found.begin.epoch == moment.epoch && moment.step <= found.last_step;
  return there ? &found : nullptr;
}

std::optional<PastCourse> HistoryRecords::course_to(api::Moment moment) const {
  const std::lock_guard lock(mutex_);
  const Segment* segment = find(moment);
  if (segment == nullptr) return std::nullopt;
  PastCourse course{segment->begin, segment->state, {}};
  for (const auto& command : segment->commands) {
    if (command->time.step >= moment.step) break;
    course.commands.push_back(command);
  }
  return course;
}

bool HistoryRecords::keeps(api::Moment moment) const {
  const std::lock_guard lock(mutex_);
  return find(moment) != nullptr;
}

std::uint64_t HistoryRecords::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

}  // namespace aprsim::world
