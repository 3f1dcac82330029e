#include "clients/wires/tcp_socket.hpp"

#include <gtest/gtest.h>

#include "tests/unit/clients/wires/listener.hpp"

namespace aprsim::client {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

constexpr const char* kHost = "127.0.0.1";

/// Says true when it is asked for the n-th time.
Cancelled at_call(int n) {
  return [n]() mutable { return --n <= 0; };
}

TEST(TcpSocket, ReceivesWhatIsSentUntilTheConnectionCloses) {
  test::Listener listener;
  auto socket = TcpSocket::connect(kHost, listener.port(), steady_clock::now() + 10s);
  ASSERT_TRUE(socket) << socket.error().message;
  listener.send("hello");
  const auto bytes = socket->receive(steady_clock::now() + 10s);
  ASSERT_TRUE(bytes) << bytes.error().message;
  EXPECT_EQ(*bytes, "hello");
  listener.hang_up();
  const auto end = socket->receive(steady_clock::now() + 10s);
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().kind, FailureKind::kConnection);
}

TEST(TcpSocket, AWaitEndsAtItsDeadline) {
  const test::Listener listener;
  auto socket = TcpSocket::connect(kHost, listener.port(), steady_clock::now() + 10s);
  ASSERT_TRUE(socket) << socket.error().message;
  for (const Cancelled& cancelled : {Cancelled(), Cancelled([] { return false; })}) {
    const auto deadline = steady_clock::now() + 30ms;
    const auto bytes = socket->receive(deadline, cancelled);
    ASSERT_FALSE(bytes);
    EXPECT_EQ(bytes.error().kind, FailureKind::kTimeout);
    EXPECT_GE(steady_clock::now(), deadline);
  }
}

TEST(TcpSocket, AWaitEndsWhenItIsCancelled) {
  const test::Listener listener;
  auto socket = TcpSocket::connect(kHost, listener.port(), steady_clock::now() + 10s);
  ASSERT_TRUE(socket) << socket.error().message;
  for (const int call : {1, 3}) {
    const auto bytes = socket->receive(steady_clock::now() + 1h, at_call(call));
    ASSERT_FALSE(bytes);
    EXPECT_EQ(bytes.error().kind, FailureKind::kInterrupted);
  }
}

TEST(TcpSocket, NobodyListening) {
  std::uint16_t port = 0;
  {
    const test::Listener listener;
    port = listener.port();
  }
  const auto socket = TcpSocket::connect(kHost, port, steady_clock::now() + 10s);
  ASSERT_FALSE(socket);
  EXPECT_EQ(socket.error().kind, FailureKind::kConnection);
}

TEST(Cancellation, ASleepEndsWhenItIsCancelled) {
  const auto far = steady_clock::now() + 1h;
  sleep_until(far, at_call(2));
  EXPECT_LT(steady_clock::now(), far);
  const auto near = steady_clock::now() + 15ms;
  sleep_until(near, [] { return false; });
  EXPECT_GE(steady_clock::now(), near);
}

}  // namespace
}  // namespace aprsim::client
