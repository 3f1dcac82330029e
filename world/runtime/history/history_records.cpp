#include "world/runtime/history/history_records.hpp"

#include <algorithm>
#include <new>
#include <utility>
#include <variant>

namespace aprsim::world {
namespace {

/// Of what is neither a state nor a command.
constexpr std::uint64_t kStretchBytes = 256, kCommandBytes = 512;
/// A cell that is reset all the time makes no endless list.
constexpr std::size_t kMaxStretches = 4000;
/// Only whole stretches are given up: commands of none take more of the memory than that, by much.
constexpr std::uint64_t kStretchesAtLeast = 8;

/// Of memory, approximately.
std::uint64_t bytes_of(const api::Command& command) {
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
  // What is asked of the simulation shows in epochs and states.
  if (std::holds_alternative<api::SimulationCommand>(command.command.body)) return;
  if (stretches_.empty() || stretches_.back().begin.epoch != time.epoch) return;
  try {
    stretches_.back().commands.push_back(
        std::make_shared<const PastCommand>(PastCommand{time, command}));
    const std::uint64_t bytes = bytes_of(command.command);
    Stretch& stretch = stretches_.back();
    const std::uint64_t state = stretch.bytes - stretch.command_bytes;
    stretch.bytes += bytes;
    stretch.command_bytes += bytes;
    bytes_ += bytes;
    const std::uint64_t most = std::max(limits_.bytes / kStretchesAtLeast, state);
    if (stretch.command_bytes > most) wants_checkpoint_ = true;
  } catch (const std::bad_alloc&) {
    // Without it nothing after it is true.
    stretches_.clear();
    bytes_ = 0;
    wants_checkpoint_ = true;
  }
}

void HistoryRecords::sampled(RunTime time, StateSample) {
  const std::lock_guard lock(mutex_);
  grow(time);
  if (stretches_.empty() || time.step - stretches_.back().begin.step >= limits_.checkpoint_steps) {
    wants_checkpoint_ = true;
  }
}

void HistoryRecords::saved(RunTime time, std::uint64_t, std::shared_ptr<const WorldState> state) {
  wants_checkpoint_ = false;
  const std::uint64_t bytes = state->bytes() + kStretchBytes;
  const std::lock_guard lock(mutex_);
  grow(time);
  Stretch next{time, std::move(state), {}, time.step, 0, bytes, 0};
  if (!stretches_.empty()) {
    const Stretch& last = stretches_.back();
    next.position = last.position + (last.last_step - last.begin.step);
  }
  stretches_.push_back(std::move(next));
  bytes_ += bytes;
  trim();
}

void HistoryRecords::stopped(RunTime time, const std::string&) { reach(time); }

void HistoryRecords::reach(RunTime time) {
  const std::lock_guard lock(mutex_);
  grow(time);
}

void HistoryRecords::grow(RunTime time) {
  if (stretches_.empty()) return;
  Stretch& last = stretches_.back();
  if (last.begin.epoch == time.epoch) last.last_step = std::max(last.last_step, time.step);
}

void HistoryRecords::trim() {
  const std::uint64_t now = stretches_.back().position;
  while (stretches_.size() > 1 && (now - stretches_[1].position > limits_.steps ||
                                   bytes_ > limits_.bytes || stretches_.size() > kMaxStretches)) {
    bytes_ -= stretches_.front().bytes;
    stretches_.pop_front();
  }
  while (epochs_.begin()->first < stretches_.front().begin.epoch) epochs_.erase(epochs_.begin());
}

std::vector<api::HistorySpan> HistoryRecords::spans() const {
  const std::lock_guard lock(mutex_);
  std::vector<api::HistorySpan> spans;
  for (const Stretch& stretch : stretches_) {
    if (spans.empty() || spans.back().epoch != stretch.begin.epoch) {
      api::HistorySpan& span = spans.emplace_back();
      span.epoch = stretch.begin.epoch;
      span.first_step = stretch.begin.step;
      if (const auto epoch = epochs_.find(span.epoch); epoch != epochs_.end()) {
        span.seed = epoch->second.seed;
        span.loaded_state = epoch->second.loaded;
      }
    }
    spans.back().last_step = stretch.last_step;
  }
  return spans;
}

const HistoryRecords::Stretch* HistoryRecords::find(api::Moment moment) const {
  // The last stretch that begins at or before the moment.
  const auto after = std::ranges::upper_bound(stretches_, moment, {}, [](const Stretch& stretch) {
    return api::Moment{stretch.begin.epoch, stretch.begin.step};
  });
  if (after == stretches_.begin()) return nullptr;
  const Stretch& found = *std::prev(after);
  const bool there = found.begin.epoch == moment.epoch && moment.step <= found.last_step;
  return there ? &found : nullptr;
}

std::optional<PastCourse> HistoryRecords::course_to(api::Moment moment) const {
  const std::lock_guard lock(mutex_);
  const Stretch* stretch = find(moment);
  if (stretch == nullptr) return std::nullopt;
  PastCourse course{stretch->begin, stretch->state, {}};
  for (const auto& command : stretch->commands) {
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
