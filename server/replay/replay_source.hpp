#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "server/replay/replay_files.hpp"
#include "server/replay/replay_pace.hpp"
#include "server/replay/replay_taps.hpp"
#include "world/api/ports/ports.hpp"
#include "world/runtime/history/history_records.hpp"
#include "world/runtime/publish/event_log.hpp"
#include "world/runtime/publish/snapshot_slot.hpp"
#include "world/runtime/record/recorder.hpp"

namespace aprsim::server {

/// Replays a recorded run at a pace, as the cell that listeners serve. It accepts no commands;
/// after its end the last state remains visible.
class ReplaySource final : public api::CommandSink, public api::SnapshotSource {
 public:
  /// `speed`: ratio of simulated to wall time; absent = as fast as possible. Throws
  /// std::runtime_error when the world cannot be built. `run` outlives it.
  ReplaySource(const journal::RecordedRun& run, journal::ReplayPart part,
               std::optional<double> speed);
  ~ReplaySource() override;
  ReplaySource(const ReplaySource&) = delete;
  ReplaySource& operator=(const ReplaySource&) = delete;

  void start();
  void stop();

  /// The reason why commands are refused.
  [[nodiscard]] std::string refusal() const;

  [[nodiscard]] Result<api::Ticket> submit(api::Command command) override;
  [[nodiscard]] api::SnapshotPtr latest() const override { return slot_.latest(); }
  [[nodiscard]] api::SnapshotPtr wait_newer(
      const api::SnapshotPtr& seen, std::chrono::steady_clock::time_point deadline) const override {
    return slot_.wait_newer(seen, deadline);
  }
  /// The first difference from the recording.
  [[nodiscard]] std::string problem() const override;
  /// The scene of the present world.
  [[nodiscard]] std::shared_ptr<const scene::Scene> scene() const {
    const std::lock_guard lock(mutex_);
    return scene_;
  }
  /// Traffic of the run's wires up to the present step.
  [[nodiscard]] ReplayTaps& taps() { return taps_; }
  /// Events of the cell up to the present step.
  [[nodiscard]] const api::EventSource& events() const { return events_; }

 private:
  using SteadyClock = std::chrono::steady_clock;
  void run(const std::stop_token& stop);
  /// Publishes and waits for the time of the next step. False when stopped.
  bool show(const world::World& world, world::RunTime time, const std::stop_token& stop);
  void publish(const world::World& world, std::uint64_t epoch);
  void measure(std::uint64_t step);
  void on_record(const v1::JournalRecord& record);
  /// Publishes the events up to this time, or all.
  void publish_events(std::optional<world::RunTime> until);

  const journal::RecordedRun& run_;
  journal::ReplayPart part_;
  const std::optional<double> speed_;
  world::SnapshotSlot slot_;
  journal::ReplayPace pace_;  ///< of the thread, also for measuring its pace
  std::uint64_t steps_ = 0, last_step_ = 0;
  SteadyClock::time_point since_{};
  double real_time_factor_ = 0;           ///< over the last second
  ReplayTaps taps_{*this};                ///< filled by the thread
  world::EventLog events_;                ///< filled by the thread
  std::deque<api::CellEventPtr> coming_;  ///< of the thread
  std::uint64_t last_event_ = 0;          ///< number of the latest event; of the thread

  mutable std::mutex mutex_;
  std::condition_variable_any pause_;
  std::string problem_;
  std::shared_ptr<const scene::Scene> scene_;
  std::jthread thread_;  // ends first
};

/// Fills a history and its bookmarks with a recorded run. Errors: of its files; a state of another
/// layout.
[[nodiscard]] Result<void> fill_history(const journal::RecordedRun& run,
                                        world::HistoryRecords& history, world::Recorder& bookmarks);

}  // namespace aprsim::server
