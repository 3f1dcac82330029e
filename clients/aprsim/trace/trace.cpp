#include "clients/aprsim/trace/trace.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "proto/journal/journal_reader.hpp"

namespace aprsim::trace {
namespace {

namespace fs = std::filesystem;
using aprsim::journal::JournalReader;

/// A file and its place in its run.
struct Part {
  std::uint32_t number = 0;
  std::string run, file;
};

Result<Part> part_of(const std::string& file) {
  auto reader = JournalReader::open(file);
  if (!reader) return tl::unexpected(reader.error());
  return Part{reader->header().part(), reader->header().run_id(), file};
}

Result<std::vector<std::string>> files_in(const std::string& directory) {
  std::vector<Part> parts;
  std::error_code status;
  for (const auto& entry : fs::directory_iterator(directory, status)) {
    if (!entry.is_regular_file(status)) continue;
    if (entry.path().filename().string().find(".journal") == std::string::npos) continue;
    auto part = part_of(entry.path().string());
    if (!part) return tl::unexpected(part.error());
    if (!parts.empty() && parts.front().run != part->run) {
      return fail(ErrorCode::kInvalidArgument, "journal",
                  fmt::format("{} has files of several runs: {} is not of that of {}", directory,
                              part->file, parts.front().file));
    }
    parts.push_back(*std::move(part));
  }
  if (status) {
    return fail(ErrorCode::kUnavailable, "journal", directory + ": " + status.message());
  }
  if (parts.empty()) {
    return fail(ErrorCode::kNotFound, "journal", directory + " has no files *.journal");
  }
  std::ranges::sort(parts, {}, &Part::number);
  std::vector<std::string> files;
  for (Part& part : parts) files.push_back(std::move(part.file));
  return files;
}

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
  // One of a later version has no name.
  if (word.size() <= kPrefix) return "event " + std::to_string(static_cast<int>(kind));
  word.erase(0, kPrefix);
  for (char& c : word) c = c == '_' ? ' ' : static_cast<char>(std::tolower(c));
  return word;
}

Result<std::vector<std::string>> files_of_run(const std::string& place) {
  std::error_code status;
  if (fs::is_directory(place, status)) return files_in(place);
  auto first = part_of(place);
  if (!first) return tl::unexpected(first.error());
  std::vector<std::string> files{place};
  for (std::uint32_t number = first->number + 1;; ++number) {
    const std::string next = fmt::format("{}.{}", place, number);
    if (!fs::exists(next, status)) return files;
    const auto part = part_of(next);
    if (!part || part->run != first->run || part->number != number) return files;
    files.push_back(next);
  }
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
  if (!ended) notes.push_back(files->back() + " does not end as a journal that was closed");
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
