#include "server/replay/replay_source.hpp"

#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "server/journal/command_message.hpp"
#include "server/journal/recorded_scenes.hpp"

namespace aprsim::server {
namespace {

/// Converts an event of the journal; null for an unknown kind.
std::shared_ptr<api::CellEvent> event_of(const v1::CellEvent& message) {
  const int kind = static_cast<int>(message.kind()) - 1;
  if (kind < 0 || kind >= api::kCellEventKinds) return nullptr;
  auto event = std::make_shared<api::CellEvent>();
  event->sequence = message.sequence();
  event->epoch = message.epoch();
  event->step = message.step();
  event->time = std::chrono::seconds(message.sim_time().seconds()) +
                std::chrono::nanoseconds(message.sim_time().nanos());
  event->kind = static_cast<api::CellEventKind>(kind);
  event->names.assign(message.names().begin(), message.names().end());
  event->text = message.text();
  event->robot = message.has_robot() ? static_cast<int>(message.robot()) : -1;
  event->number = message.number();
  return event;
}

}  // namespace

ReplaySource::ReplaySource(const journal::RecordedRun& run, journal::ReplayPart part,
                           std::optional<double> speed)
    : run_(run), part_(std::move(part)), speed_(speed), pace_(speed) {
  // Listeners query the cell before its first step.
  const world::World world(run_.scene(), run_.header().seed());
  publish(world, 0);
}

ReplaySource::~ReplaySource() { stop(); }

void ReplaySource::start() {
  thread_ = std::jthread([this](const std::stop_token& stop) { this->run(stop); });
}

void ReplaySource::stop() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

std::string ReplaySource::refusal() const {
  return fmt::format(
      "This is a replay of the recorded run {}: it can be watched, and accepts no "
      "commands.",
      run_.header().run_id());
}

Result<api::Ticket> ReplaySource::submit(api::Command) {
  return fail(ErrorCode::kFailedPrecondition, "replay", refusal());
}

std::string ReplaySource::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

void ReplaySource::run(const std::stop_token& stop) {
  part_.watch = [this, &stop](const world::World& world, world::RunTime time) {
    return show(world, time, stop);
  };
  part_.on_record = [this](const v1::JournalRecord& record) { on_record(record); };
  const auto result = journal::replay_run(run_, part_);
  if (stop.stop_requested()) return;
  if (!part_.to) {
    taps_.finish();
    publish_events({});
  }
  std::string problem;
  if (!result) {
    problem = result.error().message;
  } else if (!result->same()) {
    problem = std::string(result->difference ? "the replay differs " : "another reply ") +
              journal::text_of(result->difference ? *result->difference : *result->reply);
    problem.pop_back();  // line end
  } else {
    spdlog::info("replay: complete; {} states and {} replies compared, all equal", result->compared,
                 result->replies);
  }
  if (!problem.empty()) spdlog::error("replay: {}", problem);
  {
    auto snapshot = slot_.acquire();
    *snapshot = *slot_.latest();
    snapshot->paused = true;
    snapshot->real_time_factor = 0;
    slot_.publish(std::move(snapshot));
  }
  const std::lock_guard lock(mutex_);
  problem_ = problem;
}

bool ReplaySource::show(const world::World& world, world::RunTime time,
                        const std::stop_token& stop) {
  const auto due = pace_.due(world, time);
  if (due > SteadyClock::now()) {
    std::unique_lock lock(mutex_);
    pause_.wait_until(lock, stop, due, [] { return false; });
  }
  measure(time.step);
  publish(world, time.epoch);
  taps_.reach(time);
  publish_events(time);
  return !stop.stop_requested();
}

void ReplaySource::on_record(const v1::JournalRecord& record) {
  taps_.add(record);
  if (!record.has_event()) return;
  auto event = event_of(record.event());
  if (!event) return;
  // A log has no holes, where the journal has a gap.
  // Events of listeners have no number.
  if (last_event_ > 0 || event->sequence == 0) event->sequence = last_event_ + 1;
  last_event_ = event->sequence;
  coming_.push_back(std::move(event));
}

void ReplaySource::publish_events(std::optional<world::RunTime> until) {
  std::vector<api::CellEventPtr> reached;
  for (; !coming_.empty(); coming_.pop_front()) {
    const api::CellEvent& next = *coming_.front();
    if (until &&
        (next.epoch > until->epoch || (next.epoch == until->epoch && next.step > until->step))) {
      break;
    }
    reached.push_back(coming_.front());
  }
  if (!reached.empty()) events_.add(std::move(reached));
}

void ReplaySource::measure(std::uint64_t step) {
  if (std::exchange(last_step_, step) != step) ++steps_;
  const auto now = SteadyClock::now();
  if (since_ == SteadyClock::time_point()) since_ = now;
  const std::chrono::duration<double> wall = now - since_;
  if (wall < std::chrono::seconds(1)) return;
  real_time_factor_ = static_cast<double>(steps_) * run_.scene()->physics.step_s / wall.count();
  steps_ = 0;
  since_ = now;
}

void ReplaySource::publish(const world::World& world, std::uint64_t epoch) {
  {
    const std::lock_guard lock(mutex_);
    scene_ = world.scene();
  }
  auto snapshot = slot_.acquire();
  world.write(*snapshot);
  snapshot->epoch = epoch;
  snapshot->speed_target = speed_;
  snapshot->real_time_factor = real_time_factor_;
  slot_.publish(std::move(snapshot));
}

Result<void> fill_history(const journal::RecordedRun& run, world::HistoryRecords& history,
                          world::Recorder& bookmarks) {
  journal::RecordedScenes scenes(run.scene(), run.directory());
  bool lost = true;  // until the next checkpoint
  const auto read = run.each([&](const v1::JournalRecord& record) -> Result<bool> {
    const auto time = journal::time_of(record);
    if (record.has_gap() && record.gap().commands() > 0) lost = true;
    if (record.has_epoch()) {
      const v1::JournalEpoch& epoch = record.epoch();
      const std::string* loaded = epoch.has_loaded_state() ? &epoch.loaded_state() : nullptr;
      const auto scene = scenes.scene_of(epoch);
      if (!scene) return tl::unexpected(scene.error());
      history.began(*time, epoch.seed(), loaded, *scene);
      lost = true;
    } else if (record.has_checkpoint()) {
      auto saved = scenes.state_of(record.checkpoint());
      if (!saved) return tl::unexpected(saved.error());
      history.saved(*time, record.checkpoint().hash(),
                    std::make_shared<const world::WorldState>(std::move(*saved)));
      lost = false;
    } else if (record.has_command() && !lost) {
      auto command = journal::to_command(record.command());
      if (!command) return tl::unexpected(command.error());
      const std::string& failure = record.command().failure();
      const Error refused{ErrorCode::kInvalidArgument, "command", failure};
      const world::QueuedCommand applied{record.command().ticket(), std::move(*command)};
      history.applied(*time, applied, nullptr);
      bookmarks.applied(*time, applied, failure.empty() ? nullptr : &refused);
    } else if (record.has_event() && !lost) {
      if (const auto event = event_of(record.event())) bookmarks.happened(event);
    } else if (time && !lost) {
      history.reach(*time);
    } else if (record.has_wire() && !lost) {
      history.reach({record.wire().time().epoch(), record.wire().time().step()});
    }
    return true;
  });
  return read ? Result<void>() : tl::unexpected(read.error());
}

}  // namespace aprsim::server
