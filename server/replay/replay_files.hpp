#pragma once

#include <functional>
#include <optional>
#include <string>

#include "modbus/register_map.hpp"
#include "server/replay/recorded_run.hpp"
#include "server/replay/replay.hpp"

namespace aprsim::server::journal {

/// How much of a run is to be run again, and who looks on.
struct ReplayPart {
  std::optional<RunMoment> from;  ///< begins at the last checkpoint before it
  std::optional<RunMoment> to;    ///< ends there
  /// Scaling of the recorded run's belt; absent = replies to Modbus clients are not compared.
  std::optional<modbus::ConveyorScaling> scaling = {};
  Replay::Watch watch = {};
  /// Called with each record, those before `from` included, before it is run.
  std::function<void(const v1::JournalRecord&)> hear = {};
};

/// Runs a recorded run again and compares its states and what listeners answered. Errors:
/// kInvalidArgument for a moment that is not recorded, and for a record that cannot be, with the
/// file; kNotFound, kUnavailable. Thread: any.
[[nodiscard]] Result<ReplayResult> replay_run(const RecordedRun& run, const ReplayPart& part);

/// Where, and what is another than then, on a line.
[[nodiscard]] std::string text_of(const Difference& difference);
/// In words: what was run, and where it first differs.
[[nodiscard]] std::string text_of(const RecordedRun& run, const ReplayResult& result);
/// The same as one JSON object.
[[nodiscard]] std::string json_of(const RecordedRun& run, const ReplayResult& result);

}  // namespace aprsim::server::journal
