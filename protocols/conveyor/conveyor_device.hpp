#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "modbus/conveyor_registers.hpp"
#include "modbus/request.hpp"
#include "world/api/ports/ports.hpp"

namespace aprsim::conveyor {

/// State of the cell's conveyor and light curtain in a snapshot.
[[nodiscard]] modbus::ConveyorReadings readings_of(const api::Snapshot& snapshot);

/// The device behind the listener: PLC memory whose documented registers are the conveyor's state
/// in the latest snapshot. The protocol layer adds memory that the cell does not use, and the speed
/// exactly as written, before the belt's own limit.
/// A reset of the simulation clears the memory, as a power cycle does.
/// Thread: one at a time (the listener's).
class ConveyorDevice {
 public:
  /// `watchdog_s`: a running drive trips after this time without a write; 0 = never. The first
  /// write arms it.
  ConveyorDevice(const modbus::ConveyorScaling& scaling, api::EndpointId endpoint,
                 api::CommandSink& sink, const api::SnapshotSource& source, double watchdog_s = 0);

  /// Reads the latest snapshot; image() then belongs to it.
  void refresh();
  [[nodiscard]] const modbus::RegisterImage& image() const { return image_; }

  /// Executes a write request. A write of memory only is done at once, with ticket 0. Otherwise the
  /// drive's part is submitted, and the whole request is in image() once applied(ticket).
  [[nodiscard]] modbus::Checked<api::Ticket> write(const modbus::Request& request);

  /// Whether the write request stops the belt. The device accepts every such request, however many
  /// wait.
  [[nodiscard]] bool is_stop(const modbus::Request& request) const;

  /// Shows a write in image() before the simulation has applied it, until the next refresh().
  void show(api::Ticket ticket);

  /// Whether the snapshot of the last refresh() contains that command's effect.
  [[nodiscard]] bool applied(api::Ticket ticket) const { return ticket <= applied_; }

 private:
  struct PendingWrite {
    api::Ticket ticket = 0;
    bool coils = false;
    std::uint16_t address = 0;
    std::vector<std::uint16_t> values;  // words, or 0 and 1
  };

  [[nodiscard]] modbus::Checked<api::Ticket> write_values(const modbus::Request& request);
  /// The word that a masked write stores.
  [[nodiscard]] std::array<std::uint8_t, 2> masked_word(const modbus::Request& request) const;
  [[nodiscard]] api::ConveyorCommand command_of(const modbus::ConveyorWrite& wanted) const;
  [[nodiscard]] modbus::Checked<api::Ticket> submit(const api::ConveyorCommand& command);
  /// A holding register with the writes under way taken into account.
  [[nodiscard]] std::uint16_t latest_word(std::uint16_t address) const;
  void commit(const PendingWrite& write);
  void keep_or_forget_speed(const modbus::ConveyorReadings& readings);

  const modbus::ConveyorScaling scaling_;
  const api::EndpointId endpoint_;
  const double watchdog_s_;
  api::CommandSink& sink_;
  const api::SnapshotSource& source_;

  modbus::RegisterImage image_;
  std::deque<PendingWrite> pending_;  // by ticket
  api::Ticket applied_ = 0;
  std::optional<std::uint64_t> epoch_;
  bool has_conveyor_ = false;
  std::optional<std::uint16_t> written_speed_;
};

}  // namespace aprsim::conveyor
