#include "proto/journal/journal_reader.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <utility>

namespace aprsim::journal {

Result<JournalReader> JournalReader::open(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) {
    const int error = errno;
    return fail(error == ENOENT ? ErrorCode::kNotFound : ErrorCode::kUnavailable, "journal",
                file + ": " + std::strerror(error));
  }
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (in.bad()) {
    return fail(ErrorCode::kUnavailable, "journal", file + ": it cannot be read");
  }
  auto reader = of_bytes(std::move(bytes));
  if (!reader) {
    return fail(reader.error().code, "journal", file + ": " + reader.error().message);
  }
  return reader;
}

Result<JournalReader> JournalReader::of_bytes(std::string bytes, const UnpackedLimits& limits) {
  auto kept = std::make_unique<const std::string>(std::move(bytes));
  auto decoder = FrameDecoder::open(*kept, limits);
  if (!decoder) return tl::unexpected(decoder.error());
  JournalReader reader(std::move(kept), *std::move(decoder));
  v1::JournalRecord first;
  if (!reader.next(first) || !first.has_header()) {
    return fail(ErrorCode::kInvalidArgument, "journal",
                "it has no header" +
                    (reader.damage().empty() ? std::string() : " (" + reader.damage() + ")"));
  }
  if (first.header().format() != kFormat) {
    return fail(ErrorCode::kInvalidArgument, "journal",
                "its format is " + std::to_string(first.header().format()) +
                    ", written by version " + first.header().version() + "; expected " +
                    std::to_string(kFormat));
  }
  reader.header_ = std::move(*first.mutable_header());
  return reader;
}

bool JournalReader::next(v1::JournalRecord& record) {
  if (!damage_.empty()) return false;
  const std::string_view bytes = decoder_.next();
  if (bytes.empty()) {
    damage_ = decoder_.damage();
    return false;
  }
  if (!record.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    damage_ = "damaged: a record is no JournalRecord";
    return false;
  }
  return true;
}

}  // namespace aprsim::journal
