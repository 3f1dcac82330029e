// How many connect, how they end, and how the server starts and stops.

#include <fcntl.h>
#include <sys/resource.h>
#include <thread>
#include <unistd.h>

#include <spdlog/spdlog.h>

#include "tests/unit/protocols/modbus/listener_fixture.hpp"

namespace aprsim::modbus_server::testing {
namespace {

using modbus::testing::write_words;
using Connections = ListenerTest;

TEST_F(Connections, ManyClientsWriteAndReadTheirOwnMemory) {
  start();
  constexpr std::uint16_t kClients = 64;
  std::vector<RawClient> clients;
  for (std::uint16_t i = 0; i < kClients; ++i) clients.emplace_back(port_);
  for (std::uint16_t round = 0; round < 5; ++round) {
    for (std::uint16_t i = 0; i < kClients; ++i) {
      const auto address = static_cast<std::uint16_t>(0x8010 + i);
      const auto value = static_cast<std::uint16_t>(i * 1000 + round);
      ASSERT_TRUE(clients[i].send(adu(pdu(6, {address, value}), i)));
      ASSERT_TRUE(clients[i].send(adu(pdu(3, {address, 1}), i)));
    }
    for (std::uint16_t i = 0; i < kClients; ++i) {
      const auto value = static_cast<std::uint16_t>(i * 1000 + round);
      ASSERT_TRUE(clients[i].receive().has_value());
      ASSERT_EQ(clients[i].receive(), adu({3, 2, static_cast<std::uint8_t>(value >> 8),
                                           static_cast<std::uint8_t>(value & 0xFF)},
                                          i));
    }
  }
  EXPECT_EQ(server_->stats().open, kClients);
}

TEST_F(Connections, TheConnectionLimitHoldsAndIsFreedAgain) {
  start({.listener = {.limits = {.at_once = 3}}});
  auto first = std::make_unique<RawClient>(port_);
  RawClient second(port_), third(port_);
  for (RawClient* client : {first.get(), &second, &third}) {
    ASSERT_TRUE(client->ask(adu(kReadThree)).has_value());
  }
  RawClient fourth(port_);
  EXPECT_TRUE(fourth.ended());
  EXPECT_EQ(server_->stats().refused, 1U);
  first.reset();
  ASSERT_TRUE(eventually([&] { return server_->stats().open == 2; }));
  RawClient fifth(port_);
  EXPECT_TRUE(fifth.ask(adu(kReadThree)).has_value());
}

TEST_F(Connections, ConnectionsThatAskForNothingGiveWayToNewcomers) {
  start({.listener = {.limits = {.at_once = 3}}});
  RawClient master(port_);
  ASSERT_TRUE(master.ask(adu(kReadThree)).has_value());
  RawClient silent(port_), partial(port_);
  ASSERT_TRUE(partial.send(Bytes{0, 1, 0, 0}));
  ASSERT_TRUE(eventually([&] { return server_->stats().open == 3; }));
  RawClient fourth(port_);
  EXPECT_TRUE(fourth.ask(adu(kReadThree)).has_value());
  EXPECT_TRUE(silent.ended());
  RawClient fifth(port_);
  EXPECT_TRUE(fifth.ask(adu(kReadThree)).has_value());
  EXPECT_TRUE(partial.ended());
  EXPECT_EQ(server_->stats().refused, 0U);
  RawClient sixth(port_);
  EXPECT_TRUE(sixth.ended()) << "all others have asked for something just now";
  EXPECT_TRUE(master.ask(adu(kReadThree)).has_value());
}

TEST_F(Connections, TheLongestIdleGivesWayAfterItsTime) {
  start({.listener = {.limits = {.at_once = 2, .yield_after = 0ms}}});
  RawClient first(port_), second(port_);
  ASSERT_TRUE(first.ask(adu(kReadThree)).has_value());
  ASSERT_TRUE(second.ask(adu(kReadThree)).has_value());
  ASSERT_TRUE(first.ask(adu(kReadThree)).has_value());
  RawClient third(port_);
  EXPECT_TRUE(third.ask(adu(kReadThree)).has_value());
  EXPECT_TRUE(second.ended());
  EXPECT_TRUE(first.ask(adu(kReadThree)).has_value());
}

TEST_F(Connections, ATableFullOfOneAddressHasAPlaceForAnother) {
  start({.listener = {.limits = {.at_once = 2}}});
  RawClient first(port_), second(port_);
  ASSERT_TRUE(first.ask(adu(kReadThree)).has_value());
  ASSERT_TRUE(second.ask(adu(kReadThree)).has_value());
  RawClient same(port_);
  EXPECT_TRUE(same.ended());
  // The place that is kept, and then one of the address that has most.
  RawClient other(port_, 0, "127.0.0.2"), another(port_, 0, "127.0.0.3");
  EXPECT_TRUE(other.ask(adu(kReadThree)).has_value());
  EXPECT_TRUE(another.ask(adu(kReadThree)).has_value());
  EXPECT_TRUE(first.ended());
  EXPECT_TRUE(second.ask(adu(kReadThree)).has_value());
}

/// Any web page can make its reader's browser send this; in the second, a frame that sets the speed
/// follows.
TEST_F(Connections, BrowsersAreSentAway) {
  start();
  const Bytes write = adu(pdu(6, {0x8002, 1000}));
  const std::string frame(write.begin(), write.end());
  for (const std::string& bytes :
       {std::string("GET / HTTP/1.1\r\nHost: a\r\n\r\n"), "POST / HTTP/1.1\r\n\r\n" + frame,
        std::string("\x16\x03\x01\0\x02", 5) + "xx" + frame}) {
    RawClient browser(port_);
    // In pieces, too.
    for (const char c : bytes.substr(0, 4)) {
      ASSERT_TRUE(browser.send(Bytes{static_cast<std::uint8_t>(c)}));
    }
    (void)browser.send(Bytes(bytes.begin() + 4, bytes.end()));
    EXPECT_TRUE(browser.ended());
  }
  EXPECT_TRUE(eventually([&] { return server_->stats().dropped == 3; }));
  EXPECT_EQ(server_->stats().requests, 0U);
  EXPECT_TRUE(cell_.commands().empty());
  // A master may choose transaction ids that look like letters.
  RawClient master(port_);
  EXPECT_TRUE(master.ask(adu(kReadThree, 0x4745)).has_value());
}

TEST_F(Connections, RunningOutOfDescriptorsIsSurvived) {
  start();
  // UBSan's first look at the types behind a log line takes a descriptor.
  for (const auto level : {spdlog::level::info, spdlog::level::warn}) spdlog::log(level, "few");
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit few{128, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
  std::vector<int> fill;
  for (int fd = 0; (fd = ::open("/dev/null", O_RDONLY | O_CLOEXEC)) >= 0;) fill.push_back(fd);
  ASSERT_FALSE(fill.empty());
  ::close(fill.back());
  fill.pop_back();
  RawClient client(port_);  // takes the last one, so the server has none to accept it with
  ASSERT_TRUE(client.send(adu(kReadThree)));
  EXPECT_FALSE(client.receive(250ms).has_value());
  EXPECT_EQ(server_->stats().accepted, 0U);
  for (const int fd : fill) ::close(fd);
  EXPECT_TRUE(client.receive().has_value());
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
}

TEST_F(Connections, AnotherProtocolIsSkippedAndABrokenStreamClosed) {
  start();
  RawClient client(port_);
  ASSERT_TRUE(client.send(adu(pdu(6, {0x8000, 1}), 1, 1, 7)));
  EXPECT_EQ(client.ask(adu(pdu(3, {0x8000, 1}), 2)), adu({3, 2, 0, 0}, 2));
  RawClient web(port_);
  const std::string get = "GET / HTTP/1.1\r\n\r\n";
  ASSERT_TRUE(web.send(Bytes(get.begin(), get.end())));
  EXPECT_TRUE(web.ended());
  EXPECT_TRUE(cell_.commands().empty());
  EXPECT_TRUE(eventually([&] { return server_->stats().dropped == 1; }));
}

TEST_F(Connections, RequestsBeforeABrokenFrameAreStillAnswered) {
  start();
  cell_.hold();
  RawClient client(port_);
  Bytes stream = adu(pdu(6, {0x8000, 1}), 1);
  const Bytes read = adu(pdu(3, {0x8000, 1}), 2);
  stream.insert(stream.end(), read.begin(), read.end());
  stream.insert(stream.end(), 50, 0xFF);
  ASSERT_TRUE(client.send(stream));
  ASSERT_TRUE(eventually([&] { return cell_.commands().size() == 1; }));
  cell_.apply();
  EXPECT_EQ(client.receive(), adu(pdu(6, {0x8000, 1}), 1));
  EXPECT_EQ(client.receive(), adu({3, 2, 0, 1}, 2));
  EXPECT_TRUE(client.ended());
  EXPECT_TRUE(eventually([&] { return server_->stats().dropped == 1; }));
}

TEST_F(Connections, AHalfClosedClientStillGetsItsAnswers) {
  start();
  cell_.hold();
  RawClient client(port_);
  ASSERT_TRUE(client.send(adu(pdu(6, {0x8000, 1}), 1)));
  ASSERT_TRUE(client.send(adu(pdu(3, {0x8000, 1}), 2)));
  client.finish_sending();
  ASSERT_TRUE(eventually([&] { return cell_.commands().size() == 1; }));
  cell_.apply();
  EXPECT_EQ(client.receive(), adu(pdu(6, {0x8000, 1}), 1));
  EXPECT_EQ(client.receive(), adu({3, 2, 0, 1}, 2));
  EXPECT_TRUE(client.ended());
}

TEST_F(Connections, AResetAtAnyByteLeavesTheServerWell) {
  start();
  const Bytes frame = adu(write_words(0x8000, {1, 1, 100}));
  for (std::size_t size = 0; size <= frame.size(); ++size) {
    RawClient client(port_);
    ASSERT_TRUE(client.send(Bytes(frame.begin(), frame.begin() + static_cast<long>(size))));
    client.reset();
  }
  RawClient client(port_);
  EXPECT_TRUE(client.ask(adu(kReadThree)).has_value());
  EXPECT_TRUE(eventually([&] { return server_->stats().open == 1; }));
}

TEST_F(Connections, AWriterThatVanishesStillTakesEffect) {
  start();
  cell_.hold();
  {
    RawClient client(port_);
    ASSERT_TRUE(client.send(adu(write_words(0x8000, {1, 1, 32768, 99}))));
    ASSERT_TRUE(eventually([&] { return cell_.commands().size() == 1; }));
    client.reset();
  }
  cell_.apply();
  RawClient reader(port_);
  EXPECT_EQ(reader.ask(adu(pdu(3, {0x8002, 2}))), adu({3, 4, 0x80, 0, 0, 99}));
}

// Unread writes of a flooding client do not come between the writes of the next client.
TEST_F(Connections, AClientThatHasClosedHasOneTurnOfItsWritesExecuted) {
  start();
  cell_.hold();
  constexpr std::uint16_t kWrites = 100, kTurn = 16;
  {
    RawClient client(port_);
    ASSERT_TRUE(client.send(adu(pdu(6, {0x8000, 1}))));
    ASSERT_TRUE(eventually([&] { return cell_.commands().size() == 1; }));
    for (std::uint16_t i = 1; i <= kWrites; ++i) {
      ASSERT_TRUE(client.send(adu(pdu(6, {0x8010, i}))));
    }
  }
  cell_.apply();
  ASSERT_TRUE(eventually([&] { return server_->stats().open == 0; }));
  RawClient reader(port_);
  EXPECT_EQ(reader.ask(adu(pdu(3, {0x8010, 1}))), adu({3, 2, 0, kTurn}));
}

TEST_F(Connections, AnIdleClientIsClosedOnlyWhenConfigured) {
  start({.idle_timeout = 50ms});
  RawClient client(port_);
  EXPECT_TRUE(client.ended());
  EXPECT_EQ(server_->stats().dropped, 1U);
}

TEST_F(Connections, APortInUseIsAClearError) {
  start();
  ModbusServer second({.listener = {.port = port_}}, cell_, cell_);
  const auto failed = second.start();
  ASSERT_FALSE(failed.has_value());
  EXPECT_NE(failed.error().message.find(std::to_string(port_)), std::string::npos);
  EXPECT_NE(failed.error().message.find("in use"), std::string::npos) << failed.error().message;
}

TEST_F(Connections, BadOptionsAreNamed) {
  ModbusServer address({.listener = {.address = "nowhere"}}, cell_, cell_);
  EXPECT_EQ(address.start().error().field, "modbus.address");
  ModbusServer scale({.listener = {}, .scaling = {.full_scale_m_s = 0}}, cell_, cell_);
  EXPECT_EQ(scale.start().error().field, "modbus.full_scale_m_s");
  ModbusServer allow({.listener = {.allow = {"10.0.0.0/33"}}}, cell_, cell_);
  EXPECT_EQ(allow.start().error().field, "modbus.allow");
  EXPECT_NE(allow.start().error().message.find("10.0.0.0/33"), std::string::npos);
}

TEST_F(Connections, StoppingFinishesTheWriteUnderWay) {
  start({.listener = {.drain_deadline = 60s}, .apply_deadline = 60s});
  cell_.hold();
  RawClient writer(port_), idle(port_);
  ASSERT_TRUE(idle.ask(adu(kReadThree)).has_value());
  ASSERT_TRUE(writer.send(adu(pdu(6, {0x8000, 1}), 3)));
  ASSERT_TRUE(eventually([&] { return cell_.commands().size() == 1; }));
  std::jthread stopper([this] { server_->stop(); });
  EXPECT_TRUE(idle.ended());
  cell_.apply();
  EXPECT_EQ(writer.receive(), adu(pdu(6, {0x8000, 1}), 3));
  EXPECT_TRUE(writer.ended());
  stopper.join();
  EXPECT_EQ(server_->stats().open, 0U);
}

TEST_F(Connections, StoppingHasADeadline) {
  start({.listener = {.drain_deadline = 100ms}, .apply_deadline = 60s});
  cell_.hold();
  RawClient writer(port_);
  ASSERT_TRUE(writer.send(adu(pdu(6, {0x8000, 1}))));
  ASSERT_TRUE(eventually([&] { return cell_.commands().size() == 1; }));
  const auto begin = std::chrono::steady_clock::now();
  server_->stop();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 30s) << "not the apply deadline";
  EXPECT_TRUE(writer.ended());
}

}  // namespace
}  // namespace aprsim::modbus_server::testing
