#include "protocols/grpc/http2/http2_guard.hpp"

#include <array>
#include <chrono>
#include <string>

#include <gtest/gtest.h>

#include "protocols/grpc/http2/backoff.hpp"
#include "tests/support/http2_frames.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;
using grpc_server::Backoff;
using grpc_server::Http2Guard;
using grpc_server::Http2Limits;
using Time = Http2Guard::Clock::time_point;

const Time kNow = Time{} + 1h;

/// A connection that has been greeted.
struct Http2GuardTest : ::testing::Test {
  Http2GuardTest() { EXPECT_TRUE(guard.from_client(http2::kPreface, kNow)); }

  /// The fault of these bytes; empty = none.
  std::string client(const std::string& bytes, Time at = kNow) {
    const auto ok = guard.from_client(bytes, at);
    return ok ? "" : ok.error().message;
  }
  std::string server(const std::string& bytes, Time at = kNow) {
    const auto ok = guard.from_server(bytes, at);
    return ok ? "" : ok.error().message;
  }

  Http2Guard guard{Http2Limits{}};
};

TEST_F(Http2GuardTest, RefusesOtherProtocols) {
  Http2Guard other{Http2Limits{}};
  EXPECT_TRUE(other.from_client(std::string("PRI * HT"), kNow));
  EXPECT_TRUE(other.from_client(std::string("TP/2.0\r\n\r\nSM\r\n\r\n"), kNow));
  Http2Guard http1{Http2Limits{}};
  const auto refused = http1.from_client(std::string("GET / HTTP/1.1\r\n"), kNow);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, "it does not speak HTTP/2");
}

TEST_F(Http2GuardTest, ResetsAreBoundedASecond) {
  std::uint32_t stream = 1;
  for (int i = 0; i < 200; ++i, stream += 2) {
    ASSERT_EQ(client(http2::open_call(stream) + http2::reset(stream)), "") << i;
  }
  // A second later there is room for a hundred.
  for (int i = 0; i < 100; ++i, stream += 2) {
    ASSERT_EQ(client(http2::open_call(stream) + http2::reset(stream), kNow + 1s), "") << i;
  }
  EXPECT_EQ(client(http2::open_call(stream) + http2::reset(stream), kNow + 1s),
            "more than 100 streams reset a second");
}

TEST_F(Http2GuardTest, ResetsThatTheServerIsMadeToSendCountToo) {
  std::uint32_t stream = 1;
  for (int i = 0; i < 200; ++i, stream += 2) {
    ASSERT_EQ(client(http2::open_call(stream)), "");
    ASSERT_EQ(server(http2::reset(stream)), "");
  }
  EXPECT_NE(server(http2::reset(stream)), "");
}

TEST_F(Http2GuardTest, FramesAreFoundHoweverTheBytesCome) {
  std::string bytes;
  for (std::uint32_t stream = 1; stream < 2 * 201; stream += 2) {
    bytes += http2::open_call(stream) +
             http2::frame(http2::kData, 0, stream, std::string(300, '\3')) + http2::reset(stream);
  }
  std::string refusal;
  for (const char byte : bytes) {
    EXPECT_EQ(refusal, "");
    refusal = client(std::string(1, byte));
    if (!refusal.empty()) break;
  }
  EXPECT_EQ(guard.resets(), 201U);
  EXPECT_EQ(refusal, "more than 100 streams reset a second");
}

TEST_F(Http2GuardTest, StreamsAreOpenUntilEitherSideEndsThem) {
  std::uint32_t stream = 1;
  for (int i = 0; i < 1000; ++i, stream += 2) {
    ASSERT_EQ(client(http2::open_call(stream), kNow + i * 10ms), "");
    // Answered by trailers, or by a last frame of data.
    const auto last = i % 2 == 0 ? http2::kHeaders : http2::kData;
    ASSERT_EQ(server(http2::frame(last, http2::kEndStream, stream)), "");
  }
  for (int i = 0; i < 128; ++i, stream += 2) ASSERT_EQ(client(http2::open_call(stream)), "") << i;
  EXPECT_EQ(client(http2::open_call(stream)), "129 streams open at once, the limit is 128");
}

TEST_F(Http2GuardTest, HeaderBlocksAreBoundedInBytesAndParts) {
  const auto part = [](std::size_t size) {
    return http2::frame(http2::kContinuation, 0, 1, std::string(size, '\x82'));
  };
  ASSERT_EQ(client(http2::frame(http2::kHeaders, 0, 1)), "");
  for (int i = 0; i < 8; ++i) ASSERT_EQ(client(part(1)), "");
  EXPECT_EQ(client(part(1)), "a header block that goes on for more than 8 frames");

  Http2Guard other{Http2Limits{}};
  ASSERT_TRUE(other.from_client(http2::kPreface, kNow));
  ASSERT_TRUE(other.from_client(http2::frame(http2::kHeaders, 0, 1, std::string(9000, 'x')), kNow));
  const auto refused = other.from_client(part(9000), kNow);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, "a header block of 18000 bytes, the limit is 16384");
}

TEST_F(Http2GuardTest, AFrameOfControlIsBounded) {
  const std::string settings = http2::frame(http2::kSettings, 0, 0, std::string(16'386, '\0'));
  EXPECT_EQ(client(settings), "a frame of type 4 of 16386 bytes, the limit is 16384");
}

TEST_F(Http2GuardTest, ADataFrameMayBeAsLongAsTheProtocolAllows) {
  std::string data = http2::frame(http2::kData, 0, 1, std::string(1 << 20, 'x'));
  EXPECT_EQ(client(data), "");
  EXPECT_EQ(guard.pause(kNow), 0s);
}

TEST_F(Http2GuardTest, AClientThatLeavesManyPingsUnansweredIsNotHeard) {
  const std::string ping = http2::frame(http2::kPing, 0, 0, "12345678");
  const std::string settings = http2::frame(http2::kSettings, 0, 0);
  for (int i = 0; i < 32; ++i) {
    EXPECT_FALSE(guard.awaits_answers());
    ASSERT_EQ(client(ping + settings), "");
  }
  EXPECT_TRUE(guard.awaits_answers());
  ASSERT_EQ(server(http2::frame(http2::kPing, http2::kAck, 0, "12345678")), "");
  EXPECT_FALSE(guard.awaits_answers());
  // Its own answers are none that it awaits.
  for (int i = 0; i < 100; ++i) {
    ASSERT_EQ(client(http2::frame(http2::kSettings, http2::kAck, 0)), "");
  }
  EXPECT_FALSE(guard.awaits_answers());
}

TEST_F(Http2GuardTest, AClientThatIsTooQuickIsHeardLater) {
  const std::string empty = http2::frame(http2::kData, 0, 1);
  // A tenth of a second's worth at once.
  for (int i = 0; i < 2000; ++i) ASSERT_EQ(client(empty), "");
  EXPECT_LE(guard.pause(kNow), 1ms);
  for (int i = 0; i < 2000; ++i) ASSERT_EQ(client(empty), "");
  EXPECT_NEAR(std::chrono::duration<double>(guard.pause(kNow)).count(), 0.1, 0.01);
  EXPECT_EQ(guard.pause(kNow + 200ms), 0s);
}

TEST_F(Http2GuardTest, BetweenFramesIsKnown) {
  const std::string data = http2::frame(http2::kData, 0, 1, "abc");
  ASSERT_EQ(server(data.substr(0, 5)), "");
  EXPECT_FALSE(guard.server_between_frames());
  ASSERT_EQ(server(data.substr(5, 5)), "");
  EXPECT_FALSE(guard.server_between_frames());
  ASSERT_EQ(server(data.substr(10)), "");
  EXPECT_TRUE(guard.server_between_frames());
}

TEST(Backoff, NewConnectionsOfAnOffenderBeginOneAfterTheOther) {
  Backoff backoff;
  const auto offender = boost::asio::ip::make_address("192.0.2.1");
  const auto other = boost::asio::ip::make_address("192.0.2.2");
  std::array<int, 4> connection{};
  const auto may_begin = [&](const auto& address, std::size_t which, Time at) {
    return backoff.may_begin(address, &connection.at(which), at);
  };
  EXPECT_TRUE(may_begin(offender, 0, kNow));
  backoff.offend(offender, kNow);
  EXPECT_TRUE(backoff.on(offender, kNow));
  EXPECT_TRUE(may_begin(offender, 0, kNow));
  EXPECT_FALSE(may_begin(offender, 1, kNow));
  EXPECT_FALSE(may_begin(offender, 2, kNow));
  EXPECT_FALSE(may_begin(offender, 1, kNow + Backoff::kSpacing - 1ms));
  const Time later = kNow + Backoff::kSpacing;
  EXPECT_FALSE(may_begin(offender, 3, later)) << "others came before it";
  EXPECT_FALSE(may_begin(offender, 2, later));
  EXPECT_TRUE(may_begin(offender, 1, later));
  EXPECT_FALSE(may_begin(offender, 2, later));
  backoff.leave(offender, &connection[2]);
  EXPECT_TRUE(may_begin(offender, 3, later + Backoff::kSpacing));
  EXPECT_FALSE(backoff.on(other, kNow));
  EXPECT_TRUE(may_begin(other, 0, kNow));
  EXPECT_FALSE(backoff.on(offender, kNow + Backoff::kSpan));
  EXPECT_TRUE(may_begin(offender, 0, kNow + Backoff::kSpan));
  EXPECT_TRUE(may_begin(offender, 1, kNow + Backoff::kSpan));
}

TEST(Backoff, ManyResetsOnManyConnectionsAreAnOffence) {
  Backoff backoff;
  const auto address = boost::asio::ip::make_address("192.0.2.1");
  for (int i = 0; i < 10; ++i) backoff.count_resets(address, 100, kNow);
  EXPECT_FALSE(backoff.on(address, kNow));
  backoff.count_resets(address, 1, kNow);
  EXPECT_TRUE(backoff.on(address, kNow));
}

TEST(Backoff, RemembersABoundedNumberOfAddresses) {
  Backoff backoff;
  const auto address = [](std::uint32_t number) {
    return boost::asio::ip::address_v4(0x0A00'0000 + number);
  };
  for (std::uint32_t i = 0; i < 2 * Backoff::kMaxAddresses; ++i) {
    backoff.offend(address(i), kNow);
  }
  EXPECT_TRUE(backoff.on(address(0), kNow));
  EXPECT_FALSE(backoff.on(address(Backoff::kMaxAddresses), kNow));
  // Old ones make room.
  backoff.offend(address(5000), kNow + 2 * Backoff::kSpan);
  EXPECT_TRUE(backoff.on(address(5000), kNow + 2 * Backoff::kSpan));
}

}  // namespace
}  // namespace aprsim::test
