#include "protocols/simple_message/codec/request_framer.hpp"

#include <cstdint>
#include <span>
#include <string>

#include <gtest/gtest.h>

namespace aprsim::simple_message {
namespace {

std::span<const std::uint8_t> stream_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::string header(std::int32_t length, std::int32_t type) {
  return encode_word(length, ByteOrder::kBig) + encode_word(type, ByteOrder::kBig) +
         encode_word(2, ByteOrder::kBig) + encode_word(0, ByteOrder::kBig);
}

Cut cut(const std::string& bytes, Port port) {
  return cut_request(stream_of(bytes), port, ByteOrder::kBig);
}

TEST(RequestFramer, SizesRequestsByTypeNotByLength) {
  // As the laboratory's client states them: 136 for a point that has 148, 25 for a write with 20.
  const std::string point = header(136, 14) + std::string(136, '\0');
  EXPECT_EQ(cut(point + header(25, 2005), Port::kMotoman).size, 152U);
  const std::string write = header(25, 2005) + std::string(8, '\0');
  EXPECT_EQ(cut(write + "next", Port::kMotoman).size, 24U);
}

TEST(RequestFramer, WaitsForTheRest) {
  const std::string control = header(64, 2001) + std::string(52, '\0');
  for (std::size_t size = 0; size < control.size(); ++size) {
    EXPECT_EQ(cut(control.substr(0, size), Port::kMotoman).size, 0U) << size;
  }
  EXPECT_EQ(cut(control, Port::kMotoman).size, control.size());
}

TEST(RequestFramer, AnUnknownTypeHasItsStatedLength) {
  const Cut one = cut(header(20, 9999) + std::string(8, '\0') + "next", Port::kMotoman);
  EXPECT_EQ(one.size, 24U);
  EXPECT_TRUE(one.known_length);
}

TEST(RequestFramer, AnUnknownTypeOfAbsurdLengthIsAllThatIsThere) {
  for (const std::int32_t length : {-1, 0, 11, 1000000}) {
    const Cut all = cut(header(length, 9999) + "rest", Port::kMotoman);
    EXPECT_EQ(all.size, 20U) << length;
    EXPECT_FALSE(all.known_length);
  }
}

TEST(RequestFramer, KarelReadsTenJointsWhateverTheType) {
  const std::string joints(44, '\0');
  EXPECT_EQ(cut(header(1, 4711) + joints, Port::kFanucMotion).size, 60U);
  EXPECT_EQ(cut(header(63, 11) + joints + "12345678", Port::kFanucMotion).size, 60U);
  EXPECT_EQ(cut(header(64, 11) + joints + "12345678", Port::kFanucMotion).size, 68U);
  EXPECT_EQ(cut(header(64, 11) + joints, Port::kFanucMotion).size, 0U);
}

TEST(RequestFramer, ExtendedPointsAreThatManyGroupsOrAll) {
  const auto extended = [](std::int32_t length, std::int32_t groups, std::size_t bytes) {
    return header(length, 2016) + encode_word(groups, ByteOrder::kBig) +
           encode_word(1, ByteOrder::kBig) + std::string(bytes, '\0');
  };
  EXPECT_EQ(cut(extended(1, 1, 600), Port::kMotoman).size, 24U + 132U);
  EXPECT_EQ(cut(extended(1, 3, 600), Port::kMotoman).size, 24U + 3U * 132U);
  EXPECT_EQ(cut(extended(20 + 4 * 132, 1, 4 * 132), Port::kMotoman).size, kMaxMessageSize);
  EXPECT_EQ(cut(extended(1, 77, 4 * 132), Port::kMotoman).size, kMaxMessageSize);
}

TEST(RequestFramer, TheGripperSpeaksInWords) {
  EXPECT_EQ(cut("123", Port::kFanucGripper).size, 0U);
  EXPECT_EQ(cut("12345", Port::kFanucGripper).size, 4U);
}

}  // namespace
}  // namespace aprsim::simple_message
