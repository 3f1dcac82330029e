#include "clients/aprsim/trace/mcap_writer.hpp"

#include <algorithm>
#include <utility>

#include "proto/journal/frames.hpp"

namespace aprsim::trace {
namespace {

constexpr std::string_view kMcapMagic{"\x89MCAP0\r\n", 8};
constexpr std::size_t kChunkBytes = std::size_t{1} << 20;

/// The records' operation codes.
enum class Op : std::uint8_t {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMessageIndex = 7,
  kChunkIndex = 8,
  kStatistics = 11,
  kSummaryOffset = 14,
  kDataEnd = 15,
};

/// Serialises values for MCAP: little-endian, texts and maps with their length in bytes.
class Packed {
 public:
  template <typename Number>
  Packed& number(Number value) {
    for (std::size_t i = 0; i < sizeof value; ++i) {
      out_ += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xFFU);
    }
    return *this;
  }
  Packed& text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    out_ += text;
    return *this;
  }
  Packed& bytes(std::string_view bytes) {
    out_ += bytes;
    return *this;
  }
  template <typename Key>
  Packed& numbers(const std::vector<std::pair<Key, std::uint64_t>>& pairs) {
    number(static_cast<std::uint32_t>(pairs.size() * (sizeof(Key) + 8)));
    for (const auto& [key, value] : pairs) number(key).number(value);
    return *this;
  }
  [[nodiscard]] const std::string& get() const { return out_; }

 private:
  std::string out_;
};

std::string record(Op op, const std::string& content) {
  return Packed()
      .number(static_cast<std::uint8_t>(op))
      .number(static_cast<std::uint64_t>(content.size()))
      .bytes(content)
      .get();
}

std::vector<std::pair<std::uint16_t, std::uint64_t>> pairs_of(
    const std::map<std::uint16_t, std::uint64_t>& map) {
  return {map.begin(), map.end()};
}

}  // namespace

McapWriter::McapWriter(const std::string& file) : file_(file) {
  write(kMcapMagic);
  write(record(Op::kHeader, Packed().text("").text("aprsim").get()));
}

void McapWriter::write(std::string_view bytes) {
  file_.out().write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  at_ += bytes.size();
}

std::string McapWriter::schema_record(std::uint16_t number) const {
  const Channel& channel = channels_[number - 1U];
  return record(Op::kSchema, Packed()
                                 .number(number)
                                 .text(channel.schema)
                                 .text("jsonschema")
                                 .text(channel.schema_text)
                                 .get());
}

std::string McapWriter::channel_record(std::uint16_t number) const {
  const Channel& channel = channels_[number - 1U];
  return record(Op::kChannel, Packed()
                                  .number(number)
                                  .number(number)
                                  .text(channel.topic)
                                  .text("json")
                                  .number(std::uint32_t{0})  // no metadata
                                  .get());
}

std::uint16_t McapWriter::add_channel(const std::string& topic, const std::string& schema,
                                      const std::string& schema_text) {
  channels_.push_back({topic, schema, schema_text});
  const auto number = static_cast<std::uint16_t>(channels_.size());
  chunk_ += schema_record(number) + channel_record(number);
  return number;
}

void McapWriter::add(std::uint16_t channel, std::uint64_t time_ns, std::string_view message) {
  Channel& to = channels_[channel - 1U];
  if (index_.empty()) chunk_begin_ns_ = chunk_end_ns_ = time_ns;
  chunk_begin_ns_ = std::min(chunk_begin_ns_, time_ns);
  chunk_end_ns_ = std::max(chunk_end_ns_, time_ns);
  begin_ns_ = messages_ == 0 ? time_ns : std::min(begin_ns_, time_ns);
  end_ns_ = std::max(end_ns_, time_ns);
  index_[channel].emplace_back(time_ns, chunk_.size());
  chunk_ += record(Op::kMessage, Packed()
                                     .number(channel)
                                     .number(to.sequence++)
                                     .number(time_ns)
                                     .number(time_ns)
                                     .bytes(message)
                                     .get());
  ++to.messages;
  ++messages_;
  if (chunk_.size() >= kChunkBytes) end_chunk();
}

void McapWriter::end_chunk() {
  if (chunk_.empty()) return;
  const std::string packed = aprsim::journal::compressed(chunk_);
  Chunk chunk{.begin_ns = chunk_begin_ns_,
              .end_ns = chunk_end_ns_,
              .start = at_,
              .compressed = packed.size(),
              .plain = chunk_.size()};
  write(record(Op::kChunk, Packed()
                               .number(chunk.begin_ns)
                               .number(chunk.end_ns)
                               .number(chunk.plain)
                               .number(std::uint32_t{0})  // no checksum: zstd's frame has one
                               .text("zstd")
                               .number(chunk.compressed)
                               .bytes(packed)
                               .get()));
  chunk.length = at_ - chunk.start;
  const std::uint64_t indices = at_;
  for (auto& [channel, places] : index_) {
    chunk.index_starts[channel] = at_;
    std::ranges::stable_sort(places, {}, &std::pair<std::uint64_t, std::uint64_t>::first);
    write(record(Op::kMessageIndex, Packed().number(channel).numbers(places).get()));
  }
  chunk.index_length = at_ - indices;
  chunks_.push_back(std::move(chunk));
  chunk_.clear();
  index_.clear();
  chunk_begin_ns_ = chunk_end_ns_ = 0;
}

Result<void> McapWriter::finish() {
  end_chunk();
  write(record(Op::kDataEnd, Packed().number(std::uint32_t{0}).get()));
  const std::uint64_t summary = at_;
  std::string offsets;
  const auto group = [&](Op op, std::uint64_t start) {
    if (at_ == start) return;
    offsets += record(
        Op::kSummaryOffset,
        Packed().number(static_cast<std::uint8_t>(op)).number(start).number(at_ - start).get());
  };
  const auto count = static_cast<std::uint16_t>(channels_.size());
  std::uint64_t start = at_;
  for (std::uint16_t i = 1; i <= count; ++i) write(schema_record(i));
  group(Op::kSchema, start);
  start = at_;
  for (std::uint16_t i = 1; i <= count; ++i) write(channel_record(i));
  group(Op::kChannel, start);
  start = at_;
  std::vector<std::pair<std::uint16_t, std::uint64_t>> counts;
  for (std::uint16_t i = 1; i <= count; ++i) counts.emplace_back(i, channels_[i - 1U].messages);
  write(record(Op::kStatistics, Packed()
                                    .number(messages_)
                                    .number(count)
                                    .number(std::uint32_t{count})
                                    .number(std::uint32_t{0})
                                    .number(std::uint32_t{0})
                                    .number(static_cast<std::uint32_t>(chunks_.size()))
                                    .number(begin_ns_)
                                    .number(end_ns_)
                                    .numbers(counts)
                                    .get()));
  group(Op::kStatistics, start);
  start = at_;
  for (const Chunk& chunk : chunks_) {
    write(record(Op::kChunkIndex, Packed()
                                      .number(chunk.begin_ns)
                                      .number(chunk.end_ns)
                                      .number(chunk.start)
                                      .number(chunk.length)
                                      .numbers(pairs_of(chunk.index_starts))
                                      .number(chunk.index_length)
                                      .text("zstd")
                                      .number(chunk.compressed)
                                      .number(chunk.plain)
                                      .get()));
  }
  group(Op::kChunkIndex, start);
  const std::uint64_t summary_offsets = at_;
  write(offsets);
  write(record(Op::kFooter, Packed()
                                .number(summary)
                                .number(summary_offsets)
                                .number(std::uint32_t{0})  // no checksum
                                .get()));
  write(kMcapMagic);
  return file_.commit();
}

}  // namespace aprsim::trace
