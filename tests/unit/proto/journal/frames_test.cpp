// The layers of a journal file: what is written comes back, and what is cut off or damaged ends at
// its last complete frame.

#include "proto/journal/frames.hpp"

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "aprsim/v1/journal.pb.h"

namespace aprsim::journal {
namespace {

v1::JournalRecord numbered(std::uint32_t number, std::size_t padding = 0) {
  v1::JournalRecord record;
  record.mutable_header()->set_part(number);
  record.mutable_header()->set_scene_text(std::string(padding, 'x'));
  return record;
}

/// Two frames: records 1 and 2, and record 3.
struct TwoFrames {
  TwoFrames() {
    FrameEncoder encoder;
    encoder.add(numbered(1));
    encoder.add(numbered(2, 100'000));
    first = encoder.take();
    encoder.add(numbered(3));
    second = encoder.take();
  }
  [[nodiscard]] std::string file() const { return std::string(kMagic) + first + second; }
  std::string first, second;
};

std::vector<std::uint32_t> numbers_in(const std::string& file, std::string& damage) {
  auto decoder = FrameDecoder::open(file);
  if (!decoder) throw std::runtime_error(decoder.error().message);
  std::vector<std::uint32_t> numbers;
  for (auto bytes = decoder->next(); !bytes.empty(); bytes = decoder->next()) {
    v1::JournalRecord record;
    if (!record.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
      throw std::runtime_error("no record");
    }
    numbers.push_back(record.header().part());
  }
  damage = decoder->damage();
  return numbers;
}

using Numbers = std::vector<std::uint32_t>;

TEST(Frames, AreRefusedBeforeTheyUnpackToMoreThanTheLimits) {
  const std::string file = TwoFrames().file();
  for (const UnpackedLimits& limits :
       {UnpackedLimits{.frame = 50'000}, UnpackedLimits{.file = 10}}) {
    auto decoder = FrameDecoder::open(file, limits);
    ASSERT_TRUE(decoder.has_value());
    EXPECT_TRUE(decoder->next().empty());
    EXPECT_NE(decoder->damage().find("would unpack to"), std::string::npos) << decoder->damage();
  }
  // The limit of the file counts all frames: the first one uses it up.
  std::size_t limit = 100'000;
  while (FrameDecoder::open(file, {.file = limit})->next().empty()) ++limit;
  auto decoder = FrameDecoder::open(file, {.file = limit});
  while (!decoder->next().empty()) {
  }
  EXPECT_NE(decoder->damage().find("would unpack to"), std::string::npos) << decoder->damage();
  FrameEncoder encoder;
  encoder.add(numbered(1, kMaxFrameBytes));
  EXPECT_THROW((void)encoder.take(), std::runtime_error);
}

TEST(Frames, ComeBackWhole) {
  std::string damage;
  EXPECT_EQ(numbers_in(TwoFrames().file(), damage), (Numbers{1, 2, 3}));
  EXPECT_EQ(damage, "");
}

TEST(Frames, NothingGathersToNoFrame) {
  FrameEncoder encoder;
  EXPECT_EQ(encoder.take(), "");
}

TEST(Frames, TruncatedFileEndsWithTheLastCompleteFrame) {
  const TwoFrames frames;
  const std::string whole = frames.file();
  const std::size_t one = kMagic.size() + frames.first.size();
  for (std::size_t size = kMagic.size(); size < whole.size(); ++size) {
    std::string damage;
    const Numbers numbers = numbers_in(whole.substr(0, size), damage);
    EXPECT_EQ(numbers, size < one ? Numbers{} : (Numbers{1, 2})) << size;
    EXPECT_EQ(damage.empty(), size == one || size == kMagic.size()) << size;
  }
}

TEST(Frames, DamageIsFoundByTheChecksum) {
  const TwoFrames frames;
  std::string file = frames.file();
  file[file.size() - 1] = static_cast<char>(file[file.size() - 1] ^ 1);  // of the second checksum
  std::string damage;
  EXPECT_EQ(numbers_in(file, damage), (Numbers{1, 2}));
  EXPECT_NE(damage.find("damaged"), std::string::npos);
}

TEST(Frames, AnotherFileIsNoJournal) {
  EXPECT_EQ(FrameDecoder::open("").error().field, "journal");
  EXPECT_EQ(FrameDecoder::open("scene: aprs\nand more of it").error().field, "journal");
}

}  // namespace
}  // namespace aprsim::journal
