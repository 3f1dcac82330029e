#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "aprsim/v1/snapshot.pb.h"
#include "clients/aprsim/scenario/run_watch.hpp"
#include "clients/wires/cell_connection.hpp"
#include "clients/wires/outcome.hpp"

namespace aprsim::client {

/// Advances the virtual time of a cell from sample to sample.
class SampleTime {
 public:
  /// Keeps both references. `patience`: wall time without progress before it gives up.
  SampleTime(CellConnection& cell, RunWatch& watch, std::chrono::seconds patience)
      : cell_(cell), watch_(watch), patience_(patience) {}

  /// The cell at the next sample; absent when the controller has finished or the user
  /// interrupted. Failure: no progress for `patience`, or a controller that does not end after the
  /// run.
  [[nodiscard]] Outcome<std::optional<v1::Snapshot>> pass(bool over);

  /// Closes the CRCL connections of a dead controller, each at the time of its last poll. Time
  /// does not advance until another controller connects. A camera's feed notices at its next
  /// frame.
  [[nodiscard]] Outcome<void> pass_until_alone(std::uint64_t now,
                                               const std::vector<std::string>& roles);

 private:
  /// Requests the steps of a sample unless some are pending, and returns the cell after them;
  /// absent on timeout.
  [[nodiscard]] Outcome<std::optional<v1::Snapshot>> request(std::uint64_t now,
                                                             std::chrono::milliseconds patience);
  /// The failure of a time that does not advance, with the clients that it waits for.
  [[nodiscard]] Failure standstill();
  /// The present cell, and whether it has reached the requested step.
  [[nodiscard]] Outcome<v1::Snapshot> read();
  /// Whether time waits for a request, because the last one was cancelled before it arrived.
  [[nodiscard]] Outcome<v1::Snapshot> request_again(v1::Snapshot now);

  CellConnection& cell_;
  RunWatch& watch_;
  const std::chrono::seconds patience_;
  /// Deadline for the controller of a finished run to end.
  std::optional<std::chrono::steady_clock::time_point> home_by_;
  std::optional<std::uint64_t> goal_;  ///< requested step that is not reached yet
};

}  // namespace aprsim::client
