#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "world/base/files/draft_file.hpp"
#include "world/base/result.hpp"

namespace aprsim::trace {

/// Writes an MCAP file: chunks in zstd frames with their indices, then a summary with schemas,
/// channels, statistics and the chunks' index. Times in nanoseconds. The file is in its place once
/// finish() has succeeded. Source: MCAP specification, mcap.dev/spec, version 0 of the format.
/// Thread: one.
class McapWriter {
 public:
  explicit McapWriter(const std::string& file);

  /// A topic of JSON messages of a schema (JSON Schema); its number.
  [[nodiscard]] std::uint16_t add_channel(const std::string& topic, const std::string& schema,
                                          const std::string& schema_text);
  /// A message; the times of a channel's messages may go back.
  void add(std::uint16_t channel, std::uint64_t time_ns, std::string_view message);
  /// Errors: kUnavailable with the file.
  [[nodiscard]] Result<void> finish();
  [[nodiscard]] std::uint64_t messages() const { return messages_; }

 private:
  struct Channel {
    std::string topic, schema, schema_text;
    std::uint64_t messages = 0;
    std::uint32_t sequence = 0;
  };
  struct Chunk {
    std::uint64_t begin_ns = 0, end_ns = 0, start = 0, length = 0;
    std::map<std::uint16_t, std::uint64_t> index_starts;
    std::uint64_t index_length = 0, compressed = 0, plain = 0;
  };

  void write(std::string_view bytes);
  void end_chunk();
  [[nodiscard]] std::string schema_record(std::uint16_t number) const;
  [[nodiscard]] std::string channel_record(std::uint16_t number) const;

  files::DraftFile file_;
  std::uint64_t at_ = 0;           ///< bytes written
  std::vector<Channel> channels_;  ///< numbers from 1; each has a schema of the same number
  std::string chunk_;              ///< records, plain
  std::uint64_t chunk_begin_ns_ = 0, chunk_end_ns_ = 0;
  /// Times and offsets of each channel's messages in the present chunk.
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> index_;
  std::vector<Chunk> chunks_;
  std::uint64_t messages_ = 0, begin_ns_ = 0, end_ns_ = 0;
};

}  // namespace aprsim::trace
