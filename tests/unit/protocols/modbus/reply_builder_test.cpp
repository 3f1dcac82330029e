#include "protocols/modbus/reply_builder.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "modbus/request_validator.hpp"
#include "tests/unit/modbus/bytes.hpp"

namespace aprsim::modbus_server {
namespace {

using modbus::testing::adu;
using modbus::testing::Bytes;
using modbus::testing::pdu;
using modbus::testing::write_many;
using modbus::testing::write_words;

Bytes build(ReplyBuilder& builder, const Bytes& request, const modbus::RegisterImage& image) {
  const auto reply = builder.build(request, image);
  return {reply.begin(), reply.end()};
}

TEST(ReplyBuilder, EncodesEveryFunctionWithItsIds) {
  ReplyBuilder builder = ReplyBuilder::create().value();
  modbus::RegisterImage image;
  image.holding[2] = 0x8000;
  image.holding[3] = 0x1234;
  image.input[0xFF] = 0xABCD;
  image.coils[1] = image.coils[9] = 1;
  image.discrete[0] = 1;
  EXPECT_EQ(build(builder, adu(pdu(3, {0x8002, 2}), 0xFFFE, 255), image),
            adu({3, 4, 0x80, 0x00, 0x12, 0x34}, 0xFFFE, 255));
  EXPECT_EQ(build(builder, adu(pdu(4, {0x80FF, 1}), 2, 0), image), adu({4, 2, 0xAB, 0xCD}, 2, 0));
  EXPECT_EQ(build(builder, adu(pdu(1, {0x8000, 10})), image), adu({1, 2, 0x02, 0x02}));
  EXPECT_EQ(build(builder, adu(pdu(2, {0x8000, 1})), image), adu({2, 1, 0x01}));
  EXPECT_EQ(build(builder, adu(pdu(5, {0x8000, 0xFF00})), image), adu(pdu(5, {0x8000, 0xFF00})));
  EXPECT_EQ(build(builder, adu(pdu(6, {0x8002, 0x8000})), image), adu(pdu(6, {0x8002, 0x8000})));
  EXPECT_EQ(build(builder, adu(write_many(15, 0x8000, 9, 2, {1, 1})), image),
            adu(pdu(15, {0x8000, 9})));
  EXPECT_EQ(build(builder, adu(write_words(0x8000, {1, 2, 3})), image), adu(pdu(16, {0x8000, 3})));
}

TEST(ReplyBuilder, AMaskWriteIsEchoedAndAReadWriteReadsTheImage) {
  ReplyBuilder builder = ReplyBuilder::create().value();
  modbus::RegisterImage image;
  image.holding[0] = 0x0102;
  image.holding[1] = 0x0304;
  const Bytes mask = adu(pdu(22, {0x8000, 0x00F2, 0x0025}), 5, 6);
  EXPECT_EQ(build(builder, mask, image), mask);
  Bytes both = pdu(23, {0x8000, 2, 0x8000, 1});
  both.insert(both.end(), {2, 0xFF, 0xFF});
  EXPECT_EQ(build(builder, adu(both, 7, 8), image), adu({23, 4, 1, 2, 3, 4}, 7, 8))
      << "what the image says, not what was written";
}

TEST(ReplyBuilder, AWriteEchoLeavesTheImageAlone) {
  ReplyBuilder builder = ReplyBuilder::create().value();
  const modbus::RegisterImage image;
  build(builder, adu(pdu(6, {0x8002, 7})), image);
  EXPECT_EQ(build(builder, adu(pdu(3, {0x8002, 1})), image), adu({3, 2, 0, 0}));
}

TEST(ReplyBuilder, LongestReadsAreWhole) {
  ReplyBuilder builder = ReplyBuilder::create().value();
  modbus::RegisterImage image;
  for (std::size_t i = 0; i < image.holding.size(); ++i) {
    image.holding[i] = static_cast<std::uint16_t>(i * 259);
  }
  const Bytes reply = build(builder, adu(pdu(3, {0x8000, 125})), image);
  ASSERT_EQ(reply.size(), modbus::kHeaderSize + 2 + 250);
  for (std::size_t i = 0; i < 125; ++i) {
    EXPECT_EQ((reply[9 + 2 * i] << 8) | reply[10 + 2 * i], image.holding[i]);
  }
}

TEST(ReplyBuilder, GivesNoReplyToOtherBytes) {
  ReplyBuilder builder = ReplyBuilder::create().value();
  const modbus::RegisterImage image;
  EXPECT_TRUE(builder.build({}, image).empty());
  EXPECT_TRUE(builder.build(Bytes(7, 0), image).empty());
  EXPECT_TRUE(builder.build(Bytes(300, 0), image).empty());
  EXPECT_FALSE(builder.build(adu(pdu(3, {0x8000, 1})), image).empty())
      << "and does no lasting harm";
}

TEST(ReplyBuilder, GivesNoReplyForAddressesThatTheMemoryLacks) {
  ReplyBuilder builder = ReplyBuilder::create().value();
  const std::vector<std::uint16_t> words = {7, 8, 9};
  modbus::RegisterView memory;
  memory.first = 0xFFFD;
  memory.holding = words;
  const auto reply = builder.build(adu(pdu(3, {0xFFFE, 2})), memory);
  EXPECT_EQ(Bytes(reply.begin(), reply.end()), adu({3, 4, 0, 8, 0, 9}));
  for (const Bytes& request : {pdu(3, {0xFFFC, 1}), pdu(3, {0xFFFE, 3}), pdu(3, {0, 1}),
                               pdu(4, {0xFFFD, 1}), pdu(1, {0xFFFD, 1}), pdu(2, {0xFFFD, 1})}) {
    EXPECT_TRUE(builder.build(adu(request), memory).empty());
  }
}

TEST(ReplyBuilder, WorksOnDescriptorsBeyondSelectsReach) {
  // libmodbus' receiving side aborts the process on these.
  constexpr rlim_t kWanted = 1200;
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  ASSERT_GE(before.rlim_max, kWanted);
  const rlimit raised{std::max(before.rlim_cur, kWanted), before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &raised), 0);
  std::vector<int> fill;
  while (fill.empty() || fill.back() < 1030) {
    fill.push_back(::open("/dev/null", O_RDONLY | O_CLOEXEC));
    ASSERT_GE(fill.back(), 0);
  }
  ReplyBuilder builder = ReplyBuilder::create().value();
  EXPECT_EQ(build(builder, adu(pdu(3, {0x8000, 1})), {}), adu({3, 2, 0, 0}));
  for (const int fd : fill) ::close(fd);
}

TEST(ReplyBuilder, CostsMicroseconds) {
  ReplyBuilder builder = ReplyBuilder::create().value();
  const modbus::RegisterImage image;
  const Bytes request = adu(pdu(3, {0x8000, 125}));
  constexpr int kRounds = 20000;
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < kRounds; ++i) ASSERT_FALSE(builder.build(request, image).empty());
  const std::chrono::duration<double, std::micro> spent = std::chrono::steady_clock::now() - begin;
  std::printf("%.2f us for a reply of 125 registers\n", spent.count() / kRounds);
  EXPECT_LT(spent.count() / kRounds, 200) << "libmodbus' exception path would take 500 000";
}

}  // namespace
}  // namespace aprsim::modbus_server
