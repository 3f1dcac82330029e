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

/// A recorded run that is run again at a pace, as the cell that listeners serve. It takes no
/// commands; when it has ended, its last state stays to be looked at.
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

  /// Why nobody may command, for those who try.
  [[nodiscard]] std::string refusal() const;

  [[nodiscard]] Result<api::Ticket> submit(api::Command command) override;
  [[nodiscard]] api::SnapshotPtr latest() const override { return slot_.latest(); }
  [[nodiscard]] api::SnapshotPtr wait_newer(
      const api::SnapshotPtr& seen, std::chrono::steady_clock::time_point deadline) const override {
    return slot_.wait_newer(seen, deadline);
  }
  /// Where the run is not as it was recorded.
  [[nodiscard]] std::string problem() const override;
  /// Traffic of the run's wires, as far as it has been run.
  [[nodiscard]] ReplayTaps& taps() { return taps_; }
  /// Events of the cell, the same.
  [[nodiscard]] const api::EventSource& events() const { return events_; }

 private:
  using SteadyClock = std::chrono::steady_clock;
  void run(const std::stop_token& stop);
  /// Publishes, and waits for the time of the next step. False when told to stop.
  bool show(const world::World& world, world::RunTime time, const std::stop_token& stop);
  void publish(const world::World& world, std::uint64_t epoch);
  void measure(std::uint64_t step);
  void hear(const v1::JournalRecord& record);
  /// Events up to this time; all that have been heard of where there is none.
  void tell_events(std::optional<world::RunTime> until);

  const journal::RecordedRun& run_;
  journal::ReplayPart part_;
  const std::optional<double> speed_;
  world::SnapshotSlot slot_;
  journal::ReplayPace pace_;  ///< the thread's own, as the measure of its real pace
  std::uint64_t steps_ = 0, last_step_ = 0;
  SteadyClock::time_point since_{};
  double real_time_factor_ = 0;           ///< over the last second
  ReplayTaps taps_{*this};                ///< filled by the thread
  world::EventLog events_;                ///< the same
  std::deque<api::CellEventPtr> coming_;  ///< the thread's own
  std::uint64_t last_event_ = 0;          ///< number of the last of them; the thread's own

  mutable std::mutex mutex_;
  std::condition_variable_any pause_;
  std::string problem_;
  std::jthread thread_;  // ends first
};

/// Tells a history, and who sets its bookmarks, all that a run has recorded. Errors: as of its
/// files; of a state of another layout.
[[nodiscard]] Result<void> tell(const journal::RecordedRun& run, world::HistoryRecords& history,
                                world::Recorder& bookmarks);

}  // namespace aprsim::server
