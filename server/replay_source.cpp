#include "server/replay_source.hpp"

#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "server/journal/command_message.hpp"
#include "server/journal/recorded_scenes.hpp"

namespace aprsim::server {

ReplaySource::ReplaySource(const journal::RecordedRun& run, journal::ReplayPart part,
                           std::optional<double> speed)
    : run_(run), part_(std::move(part)), speed_(speed), pace_(speed) {
  // Listeners look at the cell before its first step.
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
      "This is the recorded run {}, run again: it can be looked at, and takes no "
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
  part_.hear = [this](const v1::JournalRecord& record) { taps_.hear(record); };
  const auto result = journal::replay_run(run_, part_);
  if (stop.stop_requested()) return;
  if (!part_.to) taps_.finish();
  std::string problem;
  if (!result) {
    problem = result.error().message;
  } else if (result->difference) {
    problem =
        fmt::format("the run differs at step {} of epoch {}: {}", result->difference->time.step,
                    result->difference->time.epoch, result->difference->what);
  } else {
    spdlog::info("replay: at its end, {} states compared, all the same", result->compared);
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
  publish(world, time.epoch);
  taps_.reach(time);
  return !stop.stop_requested();
}

void ReplaySource::publish(const world::World& world, std::uint64_t epoch) {
  auto snapshot = slot_.acquire();
  world.write(*snapshot);
  snapshot->epoch = epoch;
  snapshot->speed_target = speed_;
  slot_.publish(std::move(snapshot));
}

Result<void> tell(const journal::RecordedRun& run, world::HistoryRecords& history) {
  journal::RecordedScenes scenes(run.scene());
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
      history.applied(*time, {record.command().ticket(), std::move(*command)}, nullptr);
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
