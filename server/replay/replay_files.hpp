#pragma once

#include <functional>
#include <optional>
#include <string>

#include "modbus/register_map.hpp"
#include "server/replay/recorded_run.hpp"
#include "server/replay/replay.hpp"

namespace aprsim::server::journal {

/// The part of a run to replay, and its observers.
struct ReplayPart {
  std::optional<RunMoment> from;  ///< begin at the last checkpoint before it
  std::optional<RunMoment> to;    ///< end there
  /// Scaling of the recorded run's belt; absent = replies to Modbus clients are not compared.
  std::optional<modbus::ConveyorScaling> scaling = {};
  Replay::Watch watch = {};
  /// Called with each record before it is replayed, also with those before `from`.
  std::function<void(const v1::JournalRecord&)> on_record = {};
};

/// Replays a recorded run and compares its states and the replies of listeners. Errors:
/// kInvalidArgument for a moment that is not recorded, or with the file for an impossible record;
/// kNotFound, kUnavailable. Thread: any.
[[nodiscard]] Result<ReplayResult> replay_run(const RecordedRun& run, const ReplayPart& part);

/// A line with place and content of a difference.
[[nodiscard]] std::string text_of(const Difference& difference);
/// The result of a replay as text: what was replayed, and where it first differs.
[[nodiscard]] std::string text_of(const RecordedRun& run, const ReplayResult& result);
/// The result as a JSON object.
[[nodiscard]] std::string json_of(const RecordedRun& run, const ReplayResult& result);

}  // namespace aprsim::server::journal
