// Bytes as a journal: through the frames, through the reader's records, and what is said of them.
// Every read stays within the given bytes; every refusal must say why.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <zstd.h>

#include "aprsim/v1/journal.pb.h"
#include "proto/journal/frames.hpp"
#include "proto/journal/journal_reader.hpp"

namespace {

using namespace aprsim;

void demand(bool truth) {
  if (!truth) std::abort();
}

/// A frame of these bytes, whatever they are.
std::string frame_of(std::string_view bytes) {
  std::string frame(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(frame.data(), frame.size(), bytes.data(), bytes.size(), 1);
  demand(ZSTD_isError(size) == 0);
  frame.resize(size);
  return frame;
}

/// A whole file as it is.
void read(std::string bytes) {
  const std::size_t size = bytes.size();
  auto decoder = journal::FrameDecoder::open(bytes);
  demand(decoder.has_value() || decoder.error().field == "journal");
  if (decoder) {
    for (auto record = decoder->next(); !record.empty(); record = decoder->next()) {
      demand(decoder->good_bytes() <= size);
    }
    demand(decoder->next().empty());
    demand(decoder->good_bytes() == size || !decoder->damage().empty());
  }
  auto reader = journal::JournalReader::of_bytes(std::move(bytes));
  if (!reader) {
    demand(reader.error().field == "journal" && !reader.error().message.empty());
    return;
  }
  demand(reader->header().format() == journal::kFormat);
  v1::JournalRecord record;
  while (reader->next(record)) {
  }
  demand(!reader->next(record));
}

}  // namespace

/// The first byte says what the others are: a file, or messages, for which frames with a checksum
/// that is right are made, as no mutation would find them.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view rest(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] % 4 == 0) {
    read(std::string(rest));
    return 0;
  }
  journal::FrameEncoder encoder;
  v1::JournalRecord record;
  record.mutable_header()->set_format(journal::kFormat);
  encoder.add(record);
  std::string file = std::string(journal::kMagic) + encoder.take();
  if (data[0] % 4 == 1) {
    // One record of these bytes.
    if (record.ParseFromArray(rest.data(), static_cast<int>(rest.size()))) encoder.add(record);
    file += encoder.take();
  } else {
    file += frame_of(rest);
    // Cut off, too.
    if (data[0] % 4 == 3) file.resize(file.size() - 1 - data[0] % 8);
  }
  read(std::move(file));
  return 0;
}
