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

/// Virtual time of a cell, passed from sample to sample.
class SampleTime {
 public:
  /// Keeps both references.
  SampleTime(CellConnection& cell, RunWatch& watch) : cell_(cell), watch_(watch) {}

  /// The cell at the next sample; none when the controller does nothing more, or the user has had
  /// enough. Failure: nothing happens for long, or the controller does not end after the run.
  [[nodiscard]] Outcome<std::optional<v1::Snapshot>> pass(bool over);

  /// Lets the CRCL connections of a controller that is gone end, each at the time of its last poll.
  /// Time then stands until another controller is there. A camera's feed notices at its next frame.
  [[nodiscard]] Outcome<void> pass_until_alone(std::uint64_t now,
                                               const std::vector<std::string>& roles);

 private:
  /// Requests the steps of a sample, if none are requested: the cell after them, when they have
  /// passed in time.
  [[nodiscard]] Outcome<std::optional<v1::Snapshot>> request(std::uint64_t now,
                                                             std::chrono::milliseconds patience);
  /// The cell as it is, and whether it has got to the step that was requested.
  [[nodiscard]] Outcome<v1::Snapshot> read();
  /// Time stands until it is requested: the last request was given up before the cell heard of it.
  [[nodiscard]] Outcome<v1::Snapshot> request_again(v1::Snapshot now);

  CellConnection& cell_;
  RunWatch& watch_;
  /// When the controller of a run that is over is to have ended.
  std::optional<std::chrono::steady_clock::time_point> home_by_;
  std::optional<std::uint64_t> goal_;  ///< step that has been requested and not been reached
};

}  // namespace aprsim::client
