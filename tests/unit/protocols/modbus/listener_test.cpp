#include <map>
#include <thread>

#include "tests/unit/protocols/modbus/listener_fixture.hpp"

namespace aprsim::modbus_server::testing {
namespace {

using modbus::testing::write_words;

TEST_F(ListenerTest, TheAprsPanelsSequenceReadsBack) {
  start();
  RawClient client(port_);
  // Start as the panel does it: direction, speed, run; transaction ids from 0, unit 1.
  std::uint16_t transaction = 0;
  for (const Bytes& body : {pdu(6, {0x8001, 1}), pdu(6, {0x8002, 15000}), pdu(6, {0x8000, 1})}) {
    const Bytes frame = adu(body, transaction++);
    EXPECT_EQ(client.ask(frame), frame);
  }
  EXPECT_EQ(client.ask(adu(kReadThree, transaction)),
            adu({3, 6, 0, 1, 0, 1, 0x3A, 0x98}, transaction));
  EXPECT_EQ(cell_.commands().size(), 3U);
}

TEST_F(ListenerTest, AFrameMayArriveByteByByte) {
  start();
  RawClient client(port_);
  for (const std::uint8_t byte : adu(write_words(0x8000, {1, 0, 32768}), 5, 255)) {
    ASSERT_TRUE(client.send({byte}));
  }
  EXPECT_EQ(client.receive(), adu(pdu(16, {0x8000, 3}), 5, 255));
  EXPECT_EQ(client.ask(adu(kReadThree)), adu({3, 6, 0, 1, 0, 0, 0x80, 0}));
}

TEST_F(ListenerTest, PipelinedRequestsAreAllAnsweredInOrder) {
  start();
  RawClient client(port_);
  Bytes stream;
  std::map<std::uint16_t, Bytes> expected;
  for (std::uint16_t i = 0; i < 400; ++i) {
    // Writes, exceptions and reads in turn: none may lose or overtake another.
    const Bytes frame = i % 4 == 0   ? adu(pdu(6, {0x8002, i}), i)
                        : i % 4 == 1 ? adu(pdu(3, {0x8002, 1}), i)
                        : i % 4 == 2 ? adu(pdu(3, {0x8000, 0}), i)
                                     : adu(pdu(0x83, {0x8000, 1}), i);
    stream.insert(stream.end(), frame.begin(), frame.end());
    const auto written = static_cast<std::uint16_t>(i - i % 4);
    expected[i] = i % 4 == 0   ? frame
                  : i % 4 == 1 ? adu({3, 2, static_cast<std::uint8_t>(written >> 8),
                                      static_cast<std::uint8_t>(written & 0xFF)},
                                     i)
                  : i % 4 == 2 ? adu({0x83, 3}, i)
                               : adu({0x83, 1}, i);
  }
  std::jthread sender([&] { EXPECT_TRUE(client.send(stream)); });
  for (std::uint16_t i = 0; i < 400; ++i) EXPECT_EQ(client.receive(), expected[i]) << i;
  sender.join();
}

TEST_F(ListenerTest, AWriteIsAnsweredOnlyOnceAppliedAndDelaysNobodyElse) {
  start({.apply_deadline = 60s});
  cell_.hold();
  RawClient writer(port_), other(port_);
  ASSERT_TRUE(writer.send(adu(pdu(6, {0x8000, 1}), 1)));
  // Pipelined behind it: must wait, and must see it.
  ASSERT_TRUE(writer.send(adu(pdu(3, {0x8000, 1}), 2)));
  ASSERT_TRUE(eventually([&] { return cell_.commands().size() == 1; }));
  for (int i = 0; i < 50; ++i) {
    ASSERT_EQ(other.ask(adu(pdu(3, {0x8000, 1}))), adu({3, 2, 0, 0}));
  }
  EXPECT_FALSE(writer.receive(20ms).has_value());
  cell_.apply();
  EXPECT_EQ(writer.receive(), adu(pdu(6, {0x8000, 1}), 1));
  EXPECT_EQ(writer.receive(), adu({3, 2, 0, 1}, 2));
  EXPECT_EQ(other.ask(adu(pdu(3, {0x8000, 1}))), adu({3, 2, 0, 1}));
}

TEST_F(ListenerTest, AnUnconfirmedWriteEndsInAnException) {
  start({.apply_deadline = 50ms});
  cell_.hold();
  RawClient client(port_);
  EXPECT_EQ(client.ask(adu(pdu(6, {0x8000, 1}), 9)), adu({0x86, 4}, 9));
  cell_.apply();
  EXPECT_EQ(client.ask(adu(pdu(3, {0x8000, 1}))), adu({3, 2, 0, 1})) << "late, but it is the truth";
}

/// The simulation takes no step at all, as on a machine that starves it.
TEST_F(ListenerTest, AStopIsConfirmedWithoutAStep) {
  start({.apply_deadline = 60s});
  cell_.hold();
  RawClient client(port_);
  std::uint16_t transaction = 0;
  for (const Bytes& stop : {pdu(6, {0x8000, 0}), pdu(5, {0x8002, 0xFF00}), pdu(5, {0x8000, 0}),
                            write_words(0x8000, {0, 1, 15000}), pdu(22, {0x8000, 0, 0})}) {
    const auto reply = client.ask(adu(stop, ++transaction));
    ASSERT_TRUE(reply) << transaction;
    EXPECT_EQ((*reply)[7], stop[0]) << transaction << ": no exception";
  }
  // It reads the values that it has written.
  Bytes body = pdu(23, {0x8000, 3, 0x8000, 3});
  body.insert(body.end(), {6, 0, 0, 0, 0, 0x27, 0x10});
  EXPECT_EQ(client.ask(adu(body, 40)), adu({23, 6, 0, 0, 0, 0, 0x27, 0x10}, 40));
  EXPECT_EQ(server_->stats().exceptions, 0U);
}

/// Its connection executes one request after the other.
TEST_F(ListenerTest, AStopDoesNotWaitForTheWriteBeforeIt) {
  start({.apply_deadline = 60s});
  cell_.hold();
  RawClient client(port_);
  const Bytes stop = adu(pdu(5, {0x8002, 0xFF00}), 3);
  Bytes bytes = adu(pdu(6, {0x8000, 1}), 1);
  for (const Bytes& more : {adu(pdu(3, {0x8000, 1}), 2), stop}) {
    bytes.insert(bytes.end(), more.begin(), more.end());
  }
  client.send(bytes);
  EXPECT_EQ(client.receive(), adu({0x86, 4}, 1)) << "it is not confirmed";
  EXPECT_EQ(client.receive().value()[7], 3);
  EXPECT_EQ(client.receive(), stop);
  ASSERT_EQ(cell_.commands().size(), 2U) << "in their order";
}

TEST_F(ListenerTest, AStopIsServedBeyondTheRateOfRequests) {
  start({.max_requests_per_s = 1});
  RawClient client(port_);
  std::uint16_t transaction = 0;
  while (client.ask(adu(pdu(3, {0x8000, 1}), ++transaction)).value()[7] == 3) {
    ASSERT_LT(transaction, 1000);
  }
  const Bytes stop = adu(pdu(6, {0x8000, 0}), ++transaction);
  EXPECT_EQ(client.ask(stop), stop);
}

TEST_F(ListenerTest, ABusySimulationIsException6) {
  start();
  cell_.refuse(Error{ErrorCode::kUnavailable, "queue", "full"});
  RawClient client(port_);
  EXPECT_EQ(client.ask(adu(pdu(6, {0x8000, 1}))), adu({0x86, 6}));
  EXPECT_EQ(client.ask(adu(pdu(6, {0x8000, 2}))), adu({0x86, 3}));
  EXPECT_EQ(server_->stats().exceptions, 2U);
}

TEST_F(ListenerTest, EveryFunctionOverTheWire) {
  start();
  RawClient client(port_);
  using modbus::testing::write_many;
  Bytes read_write = pdu(23, {0x8010, 2, 0x8011, 1});
  read_write.insert(read_write.end(), {2, 0x12, 0x34});
  const std::vector<std::pair<Bytes, Bytes>> exchanges{
      {pdu(6, {0x8010, 0x12}), pdu(6, {0x8010, 0x12})},
      {pdu(22, {0x8010, 0xF2, 0x25}), pdu(22, {0x8010, 0xF2, 0x25})},
      {read_write, {23, 4, 0, 0x17, 0x12, 0x34}},
      {write_words(0x8012, {5, 6}), pdu(16, {0x8012, 2})},
      {pdu(3, {0x8011, 3}), {3, 6, 0x12, 0x34, 0, 5, 0, 6}},
      {pdu(4, {0x8008, 1}), {4, 2, 0x75, 0x30}},
      {pdu(5, {0x8010, 0xFF00}), pdu(5, {0x8010, 0xFF00})},
      {write_many(15, 0x8011, 2, 1, {2}), pdu(15, {0x8011, 2})},
      {pdu(1, {0x8010, 3}), {1, 1, 0b101}},
      {pdu(2, {0x8000, 9}), {2, 2, 1, 0}},
      {{43, 14, 4, 0}, {43, 14, 4, 0x82, 0, 0, 1, 0, 6, 'a', 'p', 'r', 's', 'i', 'm'}},
      {pdu(7, {}), {0x87, 1}},
  };
  std::uint16_t transaction = 100;
  for (const auto& [request, reply] : exchanges) {
    ++transaction;
    EXPECT_EQ(client.ask(adu(request, transaction, 17)), adu(reply, transaction, 17))
        << "function " << int{request[0]};
  }
}

TEST_F(ListenerTest, AReadWriteReadsWhatItHasWrittenOnceApplied) {
  start({.apply_deadline = 60s});
  cell_.hold();
  RawClient client(port_);
  Bytes body = pdu(23, {0x8000, 3, 0x8000, 3});
  body.insert(body.end(), {6, 0, 1, 0, 0, 0x27, 0x10});
  ASSERT_TRUE(client.send(adu(body, 4)));
  ASSERT_TRUE(eventually([&] { return cell_.commands().size() == 1; }));
  EXPECT_FALSE(client.receive(20ms).has_value());
  cell_.apply();
  EXPECT_EQ(client.receive(), adu({23, 6, 0, 1, 0, 0, 0x27, 0x10}, 4));
}

TEST_F(ListenerTest, OnlyAllowedAddressesAreServed) {
  start({.listener = {.allow = {"10.0.0.0/8", "127.0.0.2"}}});
  RawClient client(port_);
  EXPECT_TRUE(client.ended());
  EXPECT_EQ(server_->stats().refused, 1U);
  EXPECT_EQ(server_->stats().accepted, 0U);
  server_->stop();
  start({.listener = {.allow = {"127.0.0.0/8"}}});
  RawClient allowed(port_);
  EXPECT_TRUE(allowed.ask(adu(kReadThree)).has_value());
}

TEST_F(ListenerTest, ReadOnlyReadsAndRefusesWrites) {
  start({.read_only = true});
  RawClient client(port_);
  EXPECT_EQ(client.ask(adu(kReadThree)), adu({3, 6, 0, 0, 0, 1, 0, 0}));
  EXPECT_EQ(client.ask(adu(pdu(6, {0x8000, 1}))), adu({0x86, 1}));
  EXPECT_EQ(client.ask(adu(pdu(5, {0x8000, 0xFF00}))), adu({0x85, 1}));
  EXPECT_TRUE(cell_.commands().empty());
}

TEST_F(ListenerTest, AnotherUnitsRequestsAreRefusedWhenConfigured) {
  start({.unit_ids = {1, 2}});
  RawClient client(port_);
  EXPECT_TRUE(client.ask(adu(kReadThree, 1, 2)).has_value());
  EXPECT_EQ(client.ask(adu(kReadThree, 7, 3)), adu({0x83, 11}, 7, 3));
}

TEST_F(ListenerTest, AnswersBusyToAFloodingClientOnly) {
  start({.max_requests_per_s = 5});
  RawClient hasty(port_), calm(port_);
  int busy = 0;
  for (int i = 0; i < 50; ++i) {
    const auto reply = hasty.ask(adu(pdu(6, {0x8010, 1})));
    ASSERT_TRUE(reply.has_value());
    if (*reply == adu({0x86, 6})) ++busy;
  }
  EXPECT_GT(busy, 0);
  EXPECT_EQ(calm.ask(adu(kReadThree)), adu({3, 6, 0, 0, 0, 1, 0, 0}));
  EXPECT_TRUE(eventually([&] {
    return hasty.ask(adu(kReadThree)) != adu({0x83, 6});
  })) << "and may go on later";
}

}  // namespace
}  // namespace aprsim::modbus_server::testing
