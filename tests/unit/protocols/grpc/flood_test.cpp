#include <string_view>

#include <grpcpp/client_context.h>

#include "protocols/grpc/calls/unread_answers.hpp"
#include "tests/support/http2_frames.hpp"
#include "tests/support/tcp_socket.hpp"
#include "tests/unit/protocols/grpc/telemetry_fixture.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;
using Flooded = TelemetryFixture;

std::string begin() { return http2::kPreface + http2::frame(http2::kSettings, 0, 0); }

/// The server's output until it ends the connection.
std::string last_words(TcpSocket& socket) {
  std::string all;
  const auto deadline = TcpSocket::Clock::now() + 10s;
  while (true) {
    const std::string some = socket.receive(deadline);
    if (some.empty()) return all;
    all += some;
  }
}

/// Whether the server was between two frames when it ended: only there a last word fits.
bool ends_between_frames(std::string_view said) {
  constexpr std::size_t kHeader = 9;
  while (said.size() >= kHeader) {
    const auto byte = [&](std::size_t i) {
      return static_cast<std::size_t>(static_cast<unsigned char>(said[i]));
    };
    const std::size_t length = byte(0) << 16U | byte(1) << 8U | byte(2);
    if (said.size() < kHeader + length) return false;
    said.remove_prefix(kHeader + length);
  }
  return said.empty();
}

bool answers(v1::TelemetryService::Stub& stub) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + 10s);
  v1::GetCellResponse response;
  return stub.GetCell(&context, {}, &response).ok();
}

TEST_F(Flooded, RapidResetEndsTheConnectionAndNobodyElses) {
  start();
  ASSERT_TRUE(answers(*telemetry_));
  for (int round = 0; round < 5; ++round) {
    TcpSocket attacker(port_);
    std::string bytes = begin();
    for (std::uint32_t stream = 1; stream < 2 * 1000; stream += 2) {
      bytes += http2::open_call(stream) + http2::reset(stream);
    }
    attacker.send(bytes);
    const std::string answer = last_words(attacker);
    if (ends_between_frames(answer)) {
      EXPECT_NE(answer.find("streams reset a second"), std::string::npos);
      EXPECT_NE(answer.find(std::string("\0\0\0\x0B", 4)), std::string::npos)
          << "ENHANCE_YOUR_CALM";
    }
    EXPECT_TRUE(answers(*telemetry_));
  }
  // From the same address a new client is served, too.
  const auto fresh = v1::TelemetryService::NewStub(new_channel());
  EXPECT_TRUE(answers(*fresh));
  EXPECT_TRUE(answers(*telemetry_));
}

TEST_F(Flooded, StreamsThatAreOpenedOnlyEndTheConnection) {
  start();
  TcpSocket attacker(port_);
  std::string bytes = begin();
  for (std::uint32_t stream = 1; stream < 2 * 1000; stream += 2) bytes += http2::open_call(stream);
  attacker.send(bytes);
  EXPECT_NE(last_words(attacker).find("streams open at once, the limit is 128"), std::string::npos);
  EXPECT_TRUE(answers(*telemetry_));
}

TEST_F(Flooded, AHeaderBlockWithoutEndEndsTheConnection) {
  start();
  TcpSocket attacker(port_);
  std::string bytes = begin() + http2::open_call(1, 0);
  for (int i = 0; i < 1000; ++i) bytes += http2::frame(http2::kContinuation, 0, 1, "\x82");
  attacker.send(bytes);
  EXPECT_NE(last_words(attacker).find("a header block that goes on for more than 8 frames"),
            std::string::npos);
  EXPECT_TRUE(answers(*telemetry_));
}

TEST_F(Flooded, PingsWhoseAnswersNobodyReadsStopBeingHeard) {
  start();
  TcpSocket attacker(port_, 4096);
  const std::string pings = [] {
    std::string all;
    for (int i = 0; i < 1000; ++i) all += http2::frame(http2::kPing, 0, 0, "12345678");
    return all;
  }();
  ASSERT_TRUE(attacker.send(begin()));
  // As much as the kernel's buffers hold, and no more.
  std::size_t sent = 0;
  const auto deadline = TcpSocket::Clock::now() + 2s;
  while (TcpSocket::Clock::now() < deadline && sent < std::size_t{200} << 20) {
    const auto some = attacker.send_some(pings);
    if (!some) break;  // gRPC has had enough of it
    sent += *some;
    if (*some == 0) std::this_thread::yield();
  }
  EXPECT_LT(sent, std::size_t{50} << 20);
  EXPECT_TRUE(answers(*telemetry_));
}

TEST_F(Flooded, OtherProtocolsAreClosed) {
  start();
  TcpSocket browser(port_);
  browser.send("GET / HTTP/1.1\r\nHost: cell\r\n\r\n");
  EXPECT_NE(last_words(browser).find("it does not speak HTTP/2"), std::string::npos);
}

TEST_F(Flooded, AClientThatTakesNothingIsClosed) {
  start({.write_timeout = 100ms}, 300);
  TcpSocket reader(port_, 4096);
  // Windows as wide as they go, and calls whose answers fill what lies between.
  std::string bytes = begin();
  bytes += http2::frame(http2::kSettings, 0, 0, std::string_view("\0\4\x7F\xFF\xFF\xFF", 6));
  bytes += http2::frame(http2::kWindowUpdate, 0, 0, std::string_view("\x7F\0\0\0", 4));
  ASSERT_TRUE(reader.send(bytes));
  ASSERT_TRUE(eventually([&] { return server_->stats().open == 1; }));
  for (std::uint32_t stream = 1; stream < 2 * 100; stream += 2) {
    if (!reader.send(http2::open_call(stream) + http2::frame(http2::kData, http2::kEndStream,
                                                             stream,
                                                             std::string_view("\0\0\0\0\0", 5)))) {
      break;
    }
  }
  EXPECT_TRUE(eventually([&] { return server_->stats().open == 0; }));
}

TEST_F(Flooded, ManyHonestCallsPass) {
  start();
  for (int i = 0; i < 3000; ++i) ASSERT_TRUE(answers(*telemetry_)) << i;
}

/// A client that lets the server send no data: its window is 0 (RFC 9113, section 6.9.2).
class SilentReader {
 public:
  explicit SilentReader(std::uint16_t port) : socket_(port) {
    socket_.send(http2::kPreface +
                 http2::frame(http2::kSettings, 0, 0, std::string_view("\0\4\0\0\0\0", 6)));
  }
  void call(std::uint32_t stream) {
    socket_.send(http2::open_call(stream) + http2::frame(http2::kData, http2::kEndStream, stream,
                                                         std::string_view("\0\0\0\0\0", 5)));
  }
  /// Waits for the server to reset so many streams.
  bool is_reset(std::size_t streams) {
    const auto deadline = TcpSocket::Clock::now() + 10s;
    while (resets() < streams) {
      if (!socket_.readable(deadline)) return false;
      const std::string some = socket_.receive(deadline);
      if (some.empty()) return false;
      said_ += some;
    }
    return true;
  }

 private:
  [[nodiscard]] std::size_t resets() const {
    std::size_t count = 0;
    for (std::size_t at = 0; at + 9 <= said_.size();) {
      const auto byte = [&](std::size_t i) {
        return static_cast<std::size_t>(static_cast<unsigned char>(said_[at + i]));
      };
      if (byte(3) == http2::kRstStream) ++count;
      at += 9 + (byte(0) << 16U | byte(1) << 8U | byte(2));
    }
    return count;
  }

  TcpSocket socket_;
  std::string said_;
};

TEST_F(Flooded, AnswersThatNobodyReadsAreBounded) {
  grpc_server::TelemetryOptions options;
  options.max_unread_bytes = 10 * grpc_server::UnreadAnswers::kCallBytes;
  start(options);
  v1::GetCellResponse cell;
  grpc::ClientContext context;
  ASSERT_TRUE(telemetry_->GetCell(&context, {}, &cell).ok());
  const std::size_t fit =
      options.max_unread_bytes / (cell.ByteSizeLong() + grpc_server::UnreadAnswers::kCallBytes);
  constexpr std::size_t kCalls = 30;
  ASSERT_LT(fit, kCalls);
  SilentReader attacker(port_);
  for (std::uint32_t i = 0; i < kCalls; ++i) attacker.call(2 * i + 1);
  EXPECT_TRUE(attacker.is_reset(kCalls - fit));
  EXPECT_TRUE(answers(*telemetry_));
}

TEST_F(Flooded, AnAnswerThatNobodyReadsEndsItsCall) {
  grpc_server::TelemetryOptions options;
  options.write_timeout = 50ms;
  start(options);
  SilentReader attacker(port_);
  attacker.call(1);
  EXPECT_TRUE(attacker.is_reset(1));
  EXPECT_TRUE(answers(*telemetry_));
}

}  // namespace
}  // namespace aprsim::test
