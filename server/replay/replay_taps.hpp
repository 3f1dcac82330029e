#pragma once

#include <deque>
#include <map>
#include <string>

#include "aprsim/v1/journal.pb.h"
#include "protocols/record/wire_tap.hpp"
#include "world/api/ports/ports.hpp"
#include "world/runtime/record/recorder.hpp"

namespace aprsim::server {

/// The taps of a recorded run's wires, filled as the listeners' taps were. Thread: one at a time;
/// the taps any.
class ReplayTaps {
 public:
  /// `cell` provides names for requests of pages; it outlives this.
  explicit ReplayTaps(const api::SnapshotSource& cell) : cell_(cell) {}

  /// Adds a record of a wire, which is shown when the run reaches its time.
  void add(const v1::JournalRecord& record);
  /// The run has reached this time.
  void reach(world::RunTime time);
  /// Shows all waiting records.
  void finish();

  [[nodiscard]] protocols::WireTap& crcl() { return crcl_; }
  [[nodiscard]] protocols::WireTap& modbus() { return modbus_; }

 private:
  /// A snapshot source at the time of the shown record.
  class Clock final : public api::SnapshotSource {
   public:
    void set(const v1::JournalWire& wire);
    [[nodiscard]] api::SnapshotPtr latest() const override { return now_; }
    [[nodiscard]] api::SnapshotPtr wait_newer(
        const api::SnapshotPtr& /*seen*/,
        std::chrono::steady_clock::time_point /*deadline*/) const override {
      return now_;
    }
    [[nodiscard]] std::string problem() const override { return {}; }

   private:
    api::SnapshotPtr now_ = std::make_shared<const api::Snapshot>();
  };

  void show(const v1::JournalRecord& record);
  void show_crcl(const v1::JournalWire& wire, protocols::WireEvent event);
  void show_modbus(const v1::JournalWire& wire, protocols::WireEvent event);
  void show_page(const v1::JournalWire& wire, protocols::WireEvent event);

  const api::SnapshotSource& cell_;
  Clock clock_;
  protocols::WireTap crcl_{clock_}, modbus_{clock_};
  std::deque<v1::JournalRecord> waiting_;
  std::map<std::string, bool>
      ended_;  ///< by robot: whether the end of its last command was reported
};

}  // namespace aprsim::server
