#include "clients/aprsim/trace/trace.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "proto/journal/journal_place.hpp"
#include "proto/journal/journal_reader.hpp"

namespace aprsim::trace {
namespace {

using aprsim::journal::files_of_run;
using aprsim::journal::JournalReader;

std::string gap_note(const v1::JournalGap& gap) {
  return fmt::format("{} records are missing{}{}", gap.records(), gap.reason().empty() ? "" : ": ",
                     gap.reason());
}

}  // namespace

double TraceClock::at(std::uint64_t epoch, double sim_time_s) {
  if (epoch != epoch_) {
    epoch_ = epoch;
    base_s_ = latest_s_ - sim_time_s;
  }
  const double time_s = base_s_ + sim_time_s;
  latest_s_ = std::max(latest_s_, time_s);
  return time_s;
}

double seconds_of(const google::protobuf::Duration& duration) {
  return static_cast<double>(duration.seconds()) + 1e-9 * duration.nanos();
}

std::string event_word(v1::CellEventKind kind) {
  constexpr std::size_t kPrefix = sizeof("CELL_EVENT_KIND_") - 1;
  std::string word = v1::CellEventKind_Name(kind);
  // A kind of a later version has no name.
  if (word.size() <= kPrefix) return "event " + std::to_string(static_cast<int>(kind));
  word.erase(0, kPrefix);
  for (char& c : word) c = c == '_' ? ' ' : static_cast<char>(std::tolower(c));
  return word;
}

Result<std::vector<std::string>> for_each_record(
    const std::string& place, const std::function<void(const v1::JournalRecord&)>& take) {
  const auto files = files_of_run(place);
  if (!files) return tl::unexpected(files.error());
  std::vector<std::string> notes;
  bool ended = false;
  for (const std::string& file : *files) {
    auto reader = JournalReader::open(file);
    if (!reader) return tl::unexpected(reader.error());
    v1::JournalRecord record;
    if (file == files->front()) {
      *record.mutable_header() = reader->header();
      take(record);
    }
    while (reader->next(record)) {
      if (record.has_gap()) notes.push_back(gap_note(record.gap()));
      ended = ended || record.has_end();
      take(record);
    }
    if (!reader->damage().empty()) notes.push_back(file + ": " + reader->damage());
  }
  if (!ended)
    notes.push_back(files->back() +
                    " does not end with an end record: its daemon was killed or is running");
  return notes;
}

Result<Trace> read_trace(const std::string& place) {
  Trace trace{.place = place};
  TraceClock clock;
  auto notes = for_each_record(place, [&](const v1::JournalRecord& record) {
    if (record.has_header()) {
      trace.header = record.header();
    } else if (record.has_wire()) {
      const v1::JournalWire& wire = record.wire();
      trace.wires.push_back({clock.at(wire.time().epoch(), seconds_of(wire.sim_time())), wire});
    } else if (record.has_event()) {
      const v1::CellEvent& event = record.event();
      trace.events.push_back({clock.at(event.epoch(), seconds_of(event.sim_time())), event});
    }
  });
  if (!notes) return tl::unexpected(notes.error());
  trace.notes = *std::move(notes);
  return trace;
}

}  // namespace aprsim::trace
