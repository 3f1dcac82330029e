#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "world/api/values/cell_event.hpp"
#include "world/runtime/publish/event_log.hpp"
#include "world/runtime/record/run_recording.hpp"

namespace aprsim::world {

/// Gives the events of the cell their numbers, reports them to the recording, and publishes them.
/// An event is published before the snapshot that has its number. Thread: sim, but log() any.
class EventPublisher {
 public:
  /// `recording` outlives the publisher.
  explicit EventPublisher(RunRecording& recording) : recording_(recording) {}

  /// Takes all of `found`, in order, as pending events of this epoch. Without memory, the rest
  /// stays in `found` for the next call.
  void assign_event_ids(std::vector<api::CellEvent>& found, std::uint64_t epoch);
  /// Moves the pending events to the log.
  void publish_events();

  /// Events that have a number and are not published yet.
  [[nodiscard]] std::span<const api::CellEventPtr> pending() const { return pending_; }
  /// Number of the latest event; 0 = none.
  [[nodiscard]] std::uint64_t last_event() const { return last_event_; }
  /// The published events of all epochs. Thread: any.
  [[nodiscard]] const api::EventSource& log() const { return log_; }

 private:
  RunRecording& recording_;
  EventLog log_;
  std::vector<api::CellEventPtr> pending_;
  std::uint64_t last_event_ = 0;
};

}  // namespace aprsim::world
