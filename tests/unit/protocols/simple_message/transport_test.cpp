#include <random>
#include <string>

#include "protocols/record/wire_tap.hpp"
#include "protocols/simple_message/state_cadence.hpp"
#include "tests/unit/protocols/simple_message/server_fixture.hpp"

namespace aprsim::simple_message {
namespace {

using testing::eventually;
using testing::SimpleMessageClient;

class Transport : public testing::ServerTest {
 protected:
  Transport() : ServerTest(ControllerKind::kMotomanFs100) {}

  static void ping(SimpleMessageClient& client) { client.ask<Ping>(MessageType::kPing, Ping{}); }
};

TEST(StateCadence, ALateMachineSendsNoStateTwice) {
  using std::chrono::milliseconds;
  const std::chrono::steady_clock::time_point due{milliseconds(1000)};
  EXPECT_EQ(next_state(due, milliseconds(25), due + milliseconds(1)), due + milliseconds(25));
  for (const int late_ms : {25, 26, 410}) {
    const auto now = due + milliseconds(late_ms);
    EXPECT_EQ(next_state(due, milliseconds(25), now), now + milliseconds(25));
  }
}

TEST_F(Transport, ASilentStatePortStaysOpen) {
  start();
  SimpleMessageClient client(ports_.state);
  client.receive();
  faults_.begin(faults::Kind::kSimpleMessageSilent, 1);
  // States that were on their way may still come.
  EXPECT_TRUE(eventually([&] {
    while (client.readable(std::chrono::milliseconds(0))) client.receive();
    return !client.readable(kWhile);
  }));
  SimpleMessageClient motion(ports_.motion);
  ping(motion);
  faults_.end();
  client.receive();
}

TEST_F(Transport, LateRepliesComeInTheirOrder) {
  start();
  faults_.begin(faults::Kind::kSimpleMessageDelay, 1, {0.3});
  SimpleMessageClient client(ports_.motion);
  for (int i = 0; i < 2; ++i) {
    client.send({MessageType::kMotionControl, Communication::kServiceRequest, ReplyCode::kNone,
                 MotionControl{0, i, 200102, {}}});
  }
  EXPECT_FALSE(client.readable(kWhile));
  EXPECT_EQ(client.receive_body<MotionReply>().sequence, 0);
  EXPECT_EQ(client.receive_body<MotionReply>().sequence, 1);
}

TEST_F(Transport, AWrongLengthIsFourBytesTooLarge) {
  start();
  faults_.begin(faults::Kind::kSimpleMessageLength, 1);
  SimpleMessageClient client(ports_.motion);
  client.send({MessageType::kPing, Communication::kServiceRequest, ReplyCode::kNone, Ping{}});
  EXPECT_EQ(client.take(16).substr(0, 4), encode_word(16, ByteOrder::kBig));
  EXPECT_FALSE(client.readable(kWhile));
}

TEST_F(Transport, DroppedConnectionsMayReturn) {
  start();
  SimpleMessageClient motion(ports_.motion), state(ports_.state), io(ports_.gripper);
  ping(motion);
  state.receive();
  faults_.begin(faults::Kind::kSimpleMessageDrop, 1);
  EXPECT_TRUE(motion.ended());
  EXPECT_TRUE(state.ended());
  EXPECT_TRUE(io.ended());
  SimpleMessageClient again(ports_.motion);
  ping(again);
}

TEST_F(Transport, ARestartingControllerClosesItsPorts) {
  start();
  SimpleMessageClient client(ports_.motion);
  ping(client);
  faults_.begin(faults::Kind::kControllerReboot, 1);
  EXPECT_TRUE(client.ended());
  EXPECT_TRUE(eventually([&] {
    try {
      const SimpleMessageClient refused(ports_.motion);
      return false;
    } catch (const std::runtime_error&) {
      return true;
    }
  }));
  faults_.end();
  EXPECT_TRUE(eventually([&] {
    try {
      SimpleMessageClient again(ports_.motion);
      ping(again);
      return true;
    } catch (const std::runtime_error&) {
      return false;
    }
  }));
}

TEST_F(Transport, ABrowserIsSentAway) {
  start();
  SimpleMessageClient client(ports_.motion);
  client.send_bytes("GET / HTTP/1.1\r\n\r\n");
  EXPECT_TRUE(client.ended());
  EXPECT_EQ(server_->stats().dropped, 1U);
}

TEST_F(Transport, RandomBytesHarmNobody) {
  start();
  std::mt19937 random(7);
  std::uniform_int_distribution<int> byte(0, 255);
  for (const std::uint16_t port : {ports_.motion, ports_.gripper, ports_.state}) {
    for (int i = 0; i < 30; ++i) {
      try {
        SimpleMessageClient client(port);
        std::string bytes;
        for (int j = 0; j < 700; ++j) bytes += static_cast<char>(byte(random));
        // Some begin like a request.
        if (i % 2 == 0) bytes.replace(0, 6, std::string("\0\0\0\x40\0\0", 6));
        client.socket().send(bytes);
        static_cast<void>(client.readable(std::chrono::milliseconds(1)));
      } catch (const std::runtime_error&) {
        // Another client was served meanwhile.
      }
    }
  }
  EXPECT_TRUE(eventually([&] {
    SimpleMessageClient client(ports_.motion);
    ping(client);
    return true;
  }));
}

TEST_F(Transport, AFloodOfRequestsIsBounded) {
  start();
  SimpleMessageClient client(ports_.motion);
  const std::string ping =
      encode({MessageType::kPing, Communication::kServiceRequest, ReplyCode::kNone, Ping{}},
             ByteOrder::kBig);
  std::string many;
  for (int i = 0; i < 4000; ++i) many += ping;
  // A client that reads nothing is not read from for ever.
  std::size_t sent = 0;
  for (int i = 0; i < 1000; ++i) {
    const auto some = client.socket().send_some(many);
    if (!some) break;
    sent += *some;
    if (*some == 0 && !eventually([&] { return client.socket().send_some(ping).value_or(1) > 0; },
                                  std::chrono::milliseconds(200))) {
      break;
    }
  }
  EXPECT_LT(sent, std::size_t{60} * 1000 * 1000);
  EXPECT_GT(server_->stats().requests, 0U);
}

TEST_F(Transport, AReaderThatTakesNothingIsDropped) {
  options_.write_timeout = std::chrono::milliseconds(100);
  start();
  const test::TcpSocket reader(ports_.state, 2048);
  EXPECT_TRUE(eventually([&] { return server_->stats().dropped == 1; }, std::chrono::seconds(60)));
}

TEST_F(Transport, TheTapSeesCommandsAndOnlyOnRequestStates) {
  protocols::WireTap tap(cell_);
  options_.tap = &tap;
  start();
  SimpleMessageClient client(ports_.motion), state(ports_.state);
  state.receive();
  client.ask<MotionReply>(MessageType::kMotionControl, MotionControl{0, 0, 200121, {}});
  std::vector<protocols::WireEventPtr> events;
  ASSERT_TRUE(eventually([&] {
    events.clear();
    static_cast<void>(tap.read(1, true, 1 << 20, events));
    return events.size() >= 2;
  }));
  EXPECT_EQ(events[0]->source, "motion.motoman");
  EXPECT_EQ(events[0]->type, "MotionControl");
  EXPECT_TRUE(events[0]->from_client);
  EXPECT_EQ(events[0]->data.substr(0, 16), "00000040000007d1");
  EXPECT_EQ(events[1]->type, "MotionReply");
  server_->stop();
}

TEST_F(Transport, StopEndsEveryConnection) {
  start();
  SimpleMessageClient motion(ports_.motion), state(ports_.state);
  ping(motion);
  server_->stop();
  EXPECT_TRUE(motion.ended());
  EXPECT_TRUE(state.ended());
  EXPECT_EQ(server_->stats().open, 0U);
}

}  // namespace
}  // namespace aprsim::simple_message
