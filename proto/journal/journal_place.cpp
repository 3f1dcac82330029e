#include "proto/journal/journal_place.hpp"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "proto/journal/journal_reader.hpp"

namespace aprsim::journal {
namespace {

namespace fs = std::filesystem;

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
  const auto twice = std::ranges::adjacent_find(parts, {}, &Part::number);
  if (twice != parts.end()) {
    return fail(ErrorCode::kInvalidArgument, "journal",
                fmt::format("{} has two files of one part of a run, as a journal and an incident "
                            "are: {} and {}; name the one",
                            directory, twice->file, std::next(twice)->file));
  }
  std::vector<std::string> files;
  for (Part& part : parts) files.push_back(std::move(part.file));
  return files;
}

}  // namespace

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

}  // namespace aprsim::journal
