#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "aprsim/v1/journal.pb.h"
#include "proto/journal/frames.hpp"
#include "world/base/result.hpp"

namespace aprsim::journal {

/// Version of the format that this program writes, and the only one that it reads.
inline constexpr std::uint32_t kFormat = 1;

/// Reads a journal file from its beginning. Thread: one at a time.
class JournalReader {
 public:
  /// Errors: kNotFound, kUnavailable (the file cannot be read), kInvalidArgument (no journal, of
  /// another format, or damaged before its header's end); each names the file.
  [[nodiscard]] static Result<JournalReader> open(const std::string& file);
  /// The same from a file's bytes. Errors: kInvalidArgument.
  [[nodiscard]] static Result<JournalReader> of_bytes(std::string bytes,
                                                      const UnpackedLimits& limits = {});

  [[nodiscard]] const v1::JournalHeader& header() const { return header_; }
  /// The next record; false at the end, which is that of the last complete frame.
  [[nodiscard]] bool next(v1::JournalRecord& record);
  /// Why the end came early; empty = it did not.
  [[nodiscard]] const std::string& damage() const { return damage_; }

 private:
  JournalReader(std::unique_ptr<const std::string> bytes, FrameDecoder decoder)
      : bytes_(std::move(bytes)), decoder_(std::move(decoder)) {}

  std::unique_ptr<const std::string> bytes_;  ///< of the file
  FrameDecoder decoder_;
  v1::JournalHeader header_;
  std::string damage_;
};

}  // namespace aprsim::journal
