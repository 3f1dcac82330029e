#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <google/protobuf/duration.pb.h>

#include "aprsim/v1/journal.pb.h"
#include "world/base/result.hpp"

/// Traces: the traffic of a run, from its journal or from a network capture.
namespace aprsim::trace {

/// One message on a wire.
struct WireRecord {
  double time_s = 0;  ///< simulated, since the trace's beginning, also over resets
  v1::JournalWire wire;
};

/// An event of the cell.
struct EventRecord {
  double time_s = 0;  ///< as of a WireRecord
  v1::CellEvent event;
};

struct Trace {
  std::string place;  ///< the file or directory that was read
  v1::JournalHeader header;
  std::vector<WireRecord> wires;    ///< in the order of recording
  std::vector<EventRecord> events;  ///< likewise
  std::vector<std::string> notes;   ///< a sentence for everything that is missing
};

/// Simulated time since the beginning of a trace, continuous over resets.
class TraceClock {
 public:
  [[nodiscard]] double at(std::uint64_t epoch, double sim_time_s);

 private:
  std::uint64_t epoch_ = 0;
  double base_s_ = 0, latest_s_ = 0;
};

[[nodiscard]] double seconds_of(const google::protobuf::Duration& duration);

/// "protective stop".
[[nodiscard]] std::string event_word(v1::CellEventKind kind);

/// Calls `take` with every record of a run except the headers of further files. Returns a note for
/// everything that is missing. Errors: those of journal::files_of_run().
[[nodiscard]] Result<std::vector<std::string>> for_each_record(
    const std::string& place, const std::function<void(const v1::JournalRecord&)>& take);

/// Reads the wires and events of a run. Errors: those of journal::files_of_run().
[[nodiscard]] Result<Trace> read_trace(const std::string& place);

}  // namespace aprsim::trace
