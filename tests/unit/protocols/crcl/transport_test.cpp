// Sockets: splitting, limits, peers that misbehave, shutting down.

#include <cmath>
#include <random>
#include <thread>
#include <vector>

#include "tests/support/eventually.hpp"
#include "tests/support/injected_faults.hpp"
#include "tests/unit/protocols/crcl/server_fixture.hpp"

namespace aprsim::crcl_server {
namespace {

class Transport : public ServerTest {
 protected:
  template <typename Condition>
  void wait_for(Condition condition) {
    EXPECT_TRUE(test::eventually(condition));
  }
  void wait_for_open(std::uint64_t open) {
    wait_for([&] { return server_->stats().open == open; });
  }
  void wait_for_dropped(std::uint64_t dropped) {
    wait_for([&] { return server_->stats().dropped == dropped; });
  }

  const std::string get_status_ = crcl::with_id("GetStatusType", "");
};

TEST_F(Transport, PacketBordersDoNotMatter) {
  TestClient client(port_);
  std::string stream("\0\r\n", 3);
  for (int i = 0; i < 30; ++i) {
    stream += "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- \xC3\xA4 -->" + get_status_;
    stream += std::string(1, '\0') + "\n";
  }
  std::mt19937 random(7);
  std::size_t at = 0;
  while (at < stream.size()) {
    const std::size_t size = 1 + random() % 90;
    client.send(std::string_view(stream).substr(at, size));
    at += size;
  }
  client.finish_sending();
  for (int i = 1; i <= 30; ++i) EXPECT_EQ(client.read_status().command.status_id, i);
  client.expect_closed();
}

/// Any web page can make its reader's browser send this.
TEST_F(Transport, HttpLeavesNoTraceInTheRobot) {
  TestClient controller(port_);
  initialize(controller);
  const std::string body = crcl::with_id("StopMotionType", "<StopCondition>Fast</StopCondition>");
  for (const std::string& request :
       {"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: " + std::to_string(body.size()) +
            "\r\n\r\n" + body,
        std::string("GET /status HTTP/1.1\r\n\r\n"), std::string("\x16\x03\x01\x02\x00", 5)}) {
    TestClient browser(port_);
    browser.send(request);
    browser.expect_closed();
  }
  expect(controller.status(), 4, CommandState::kDone);
  EXPECT_EQ(world_.commands().size(), 1U) << "nothing but the controller's InitCanon";
}

TEST_F(Transport, ConnectionsBeyondTheLimitAreClosed) {
  CrclServerOptions options;
  options.listener.limits.at_once = 3;
  start(options);
  std::vector<std::unique_ptr<TestClient>> clients;
  for (int i = 0; i < 3; ++i) {
    clients.push_back(std::make_unique<TestClient>(port_));
    clients.back()->status();
  }
  TestClient(port_).expect_closed();
  EXPECT_EQ(server_->stats().refused, 1U);
  for (auto& client : clients) client->status();
  clients.pop_back();
  wait_for_open(2);
  TestClient(port_).status();
}

TEST_F(Transport, SixtyFourClientsAreServed) {
  std::vector<std::unique_ptr<TestClient>> clients;
  for (int i = 0; i < 64; ++i) clients.push_back(std::make_unique<TestClient>(port_));
  for (int round = 0; round < 5; ++round) {
    for (auto& client : clients) client->send(get_status_);
    for (auto& client : clients) client->read_status();
  }
}

TEST_F(Transport, AWideEncodingIsRefusedAloud) {
  TestClient witness(port_);
  TestClient client(port_);
  std::string wide = "\xFF\xFE";
  for (const char c : get_status_) wide += {c, '\0'};
  client.send(wide);
  client.expect_closed();
  const crcl::CommandStatus status = witness.status().command;
  EXPECT_EQ(status.state, CommandState::kError);
  EXPECT_NE(status.description->find("the document is in UTF-16 or UTF-32, expected UTF-8"),
            std::string::npos)
      << *status.description;
}

TEST_F(Transport, ADocumentThatIsTooLargeEndsTheConnection) {
  TestClient client(port_);
  TestClient witness(port_);
  client.send("<CRCLCommandInstance>" + std::string(70'000, 'x'));
  client.expect_closed();
  const crcl::CommandStatus status = witness.status().command;
  EXPECT_EQ(status.state, CommandState::kError);
  EXPECT_NE(status.description->find("65536 bytes"), std::string::npos);
}

/// The limit of one document times the number of connections would be more than a daemon has.
TEST_F(Transport, UnfinishedDocumentsAreBoundedTogether) {
  CrclServerOptions options;
  options.max_unfinished_bytes = 500'000;
  start(options);
  const auto begun = [](std::size_t bytes) { return "<CRCLProgram>" + std::string(bytes, ' '); };
  TestClient small(port_), middle(port_), large(port_);
  small.send(begun(100'000));
  middle.send(begun(150'000));
  large.send(begun(400'000));
  large.expect_closed();
  TestClient other(port_);
  other.status();
  wait_for_open(3);
  // The others' documents are complete later and are read.
  for (TestClient* client : {&small, &middle}) {
    client->send("</CRCLProgram>");
    client->status();  // throws where the connection is closed
  }
}

TEST_F(Transport, AFloodIsAnsweredInFull) {
  CrclServerOptions options;
  options.write_timeout = std::chrono::minutes(1);  // a busy machine's client reads slowly
  start(options);
  TestClient flood(port_);
  TestClient other(port_);
  constexpr int kFlood = 3000;
  std::jthread reader([&] {
    EXPECT_NO_THROW({
      for (int i = 0; i < kFlood; ++i) flood.read_status();
    });
  });
  std::string packet;
  for (int i = 0; i < 100; ++i) packet += get_status_;
  for (int i = 0; i < kFlood; i += 100) {
    flood.send(packet);
    other.status();  // throws when it waits for long
  }
  reader.join();
}

TEST_F(Transport, APeerThatDoesNotReadIsBoundedAndThenDropped) {
  CrclServerOptions options;
  options.write_timeout = std::chrono::milliseconds(300);
  start(options);
  TestClient deaf(port_, 4096);
  TestClient other(port_);
  std::string packet;
  for (int i = 0; i < 2000; ++i) packet += get_status_;
  try {
    for (int i = 0; i < 20; ++i) deaf.send(packet);  // fails once the server has closed
  } catch (const std::runtime_error&) {
  }
  other.status();
  wait_for_dropped(1);
  // Far fewer statuses were made than asked for: reading stopped with the output full.
  EXPECT_LT(server_->stats().statuses, 20'000U);
  other.status();
  wait_for_open(1);
}

TEST_F(Transport, StatusesWaitForAPeerThatReadsLate) {
  CrclServerOptions options;
  options.write_timeout = std::chrono::minutes(1);  // a busy machine's client reads slowly
  start(options);
  TestClient late(port_);
  std::string packet;
  for (int i = 0; i < 500; ++i) packet += get_status_;
  late.send(packet);
  TestClient(port_).status();
  for (int i = 0; i < 500; ++i) late.read_status();
}

TEST_F(Transport, HalfADocumentHoldsUpNobody) {
  TestClient half(port_);
  half.send("<CRCLCommandInstance><CRCLComm");
  TestClient other(port_);
  for (int i = 0; i < 10; ++i) other.status();
}

TEST_F(Transport, PeersThatVanishHarmNobody) {
  TestClient witness(port_);
  initialize(witness);
  const std::string command = crcl::with_id("MoveToType", move());
  for (std::size_t cut = 0; cut < command.size(); cut += 40) {
    TestClient client(port_);
    client.send(get_status_ + get_status_ + command.substr(0, cut));
    client.read_status();  // accepted, for a connection that is gone before that counts nowhere
    client.reset();
    wait_for([&] { return server_->stats().accepted == 2 + cut / 40; });
  }
  wait_for_open(1);
  EXPECT_EQ(witness.status().command.state, CommandState::kDone);
  EXPECT_EQ(server_->stats().dropped, 0U);
}

// Commands that clients have sent, in their order: the connection of each is its last digit.
class GoneClients : public Transport {
 protected:
  static std::string rate(int mm_s) {
    return crcl::instance("SetTransSpeedType",
                          "<CommandID>7</CommandID><TransSpeed "
                          "xsi:type=\"TransSpeedAbsoluteType\"><Setting>" +
                              std::to_string(mm_s) + "</Setting></TransSpeed>");
  }
};

TEST_F(GoneClients, TheirUnreadCommandsDoNotGetBetweenThoseOfTheNext) {
  TestClient first(port_);
  initialize(first);
  constexpr int kClients = 50;
  std::string flood;
  for (int i = 0; i < 400; ++i) flood += rate(100);
  for (int i = 0; i < kClients; ++i) TestClient(port_).send(flood);
  // All have closed. Nearly all of what they have sent is unread.
  TestClient next(port_);
  next.command(8, "InitCanonType");
  next.send(rate(200) + rate(201));
  expect(next.status(), 7, CommandState::kDone);
  wait_for_open(2);
  expect(next.status(), 7, CommandState::kDone);
  const std::vector<api::Command> taken = world_.commands();
  ASSERT_GE(taken.size(), 4U);
  const auto speed = [&](std::size_t from_end) {
    const auto& action = std::get<api::RobotCommand>(taken[taken.size() - from_end].body).action;
    const auto* set = std::get_if<api::SetMotionLimit>(&action);
    return set == nullptr ? 0 : std::lround(set->value * 1e3);
  };
  EXPECT_EQ(speed(1), 201);
  EXPECT_EQ(speed(2), 200);
  const auto& before = std::get<api::RobotCommand>(taken[taken.size() - 3].body).action;
  EXPECT_TRUE(std::holds_alternative<api::InitRobot>(before)) << "nothing of theirs in between";
  EXPECT_EQ(server_->stats().refused, 0U);
}

// While an injected fault holds the document at hand back, nothing is read from the peer.
TEST_F(GoneClients, TheirCommandsAreDroppedAlsoWhileReadingPauses) {
  test::InjectedFaultsOf faults(world_);
  TestClient client(port_);
  initialize(client);
  faults.begin(faults::Kind::kCrclSlow, 0, {0.3});
  std::string commands;
  for (int i = 0; i < 12; ++i) commands += rate(100);
  TestClient(port_).send(commands);
  wait_for([&] { return server_->stats().accepted == 2; });
  wait_for_open(1);
  EXPECT_LT(world_.commands().size(), 13U) << "of one that has closed";

  const std::size_t before = world_.commands().size();
  TestClient lost(port_);
  lost.send(commands);
  wait_for([&] { return server_->stats().commands > 5; });
  lost.reset();
  wait_for_open(1);
  EXPECT_LT(world_.commands().size(), before + 12) << "of one that was reset";
}

// One turn of them, as much as a program that sends and leaves at once may have meant.
TEST_F(GoneClients, WhatTheySendLastIsExecuted) {
  TestClient client(port_);
  initialize(client);
  std::string commands;
  for (int i = 0; i < 12; ++i) commands += rate(100);
  TestClient(port_).send(commands);
  wait_for([&] { return server_->stats().accepted == 2; });
  wait_for_open(1);
  EXPECT_EQ(world_.commands().size(), 13U);
}

TEST_F(Transport, IdleConnectionsEndOnlyWhenConfigured) {
  CrclServerOptions options;
  options.idle_timeout = std::chrono::milliseconds(50);
  start(options);
  TestClient client(port_);
  client.expect_closed();
  wait_for_dropped(1);
}

TEST_F(Transport, AnIncompleteDocumentIsNotWaitedForLongHoweverItDrips) {
  CrclServerOptions options;
  options.document_timeout = std::chrono::milliseconds(300);
  start(options);
  TestClient witness(port_);
  initialize(witness);
  TestClient silent(port_), dripping(port_);
  silent.send("<CRCLCommandInstance>");
  std::jthread drip([&](const std::stop_token& stop) {
    try {
      dripping.send("<CRCLCommandInstance>");
      while (!stop.stop_requested()) {
        dripping.send(" ");
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
    } catch (const std::runtime_error&) {  // closed
    }
  });
  wait_for_dropped(2);
  // A client with earlier requests gets no more time; silence between documents is no fault.
  TestClient asked(port_);
  asked.status();
  asked.send(get_status_.substr(0, 20));
  wait_for_dropped(3);
  expect(witness.status(), 4, CommandState::kDone);
  EXPECT_EQ(world_.commands().size(), 1U) << "nothing but the InitCanon";
  wait_for_open(1);
}

TEST_F(Transport, ConnectionsThatAskForNothingGiveWayToNewcomers) {
  CrclServerOptions options;
  options.listener.limits.at_once = 4;
  start(options);
  TestClient controller(port_);
  initialize(controller);
  std::vector<std::unique_ptr<TestClient>> idle;
  for (int i = 0; i < 3; ++i) idle.push_back(std::make_unique<TestClient>(port_));
  idle[1]->send("<CRCLCommandInstance>");
  wait_for_open(4);
  for (int i = 0; i < 3; ++i) {
    idle.push_back(std::make_unique<TestClient>(port_));
    idle.back()->status();
    EXPECT_NO_THROW(idle[static_cast<std::size_t>(i)]->expect_closed()) << i;
  }
  EXPECT_EQ(server_->stats().refused, 0U);
  // Now all have asked for something just now.
  TestClient(port_).expect_closed();
  EXPECT_EQ(server_->stats().refused, 1U);
  controller.status();
}

TEST_F(Transport, ATableFullOfOneAddressHasAPlaceForAnother) {
  CrclServerOptions options;
  options.listener.limits.at_once = 3;
  start(options);
  std::vector<std::unique_ptr<TestClient>> hog;
  for (int i = 0; i < 3; ++i) {
    hog.push_back(std::make_unique<TestClient>(port_));
    hog.back()->status();
  }
  TestClient(port_).expect_closed();
  TestClient second(port_, 0, "127.0.0.2");
  second.status();
  // The place that was kept is taken: one of the address that has most is given up.
  TestClient third(port_, 0, "127.0.0.3");
  third.status();
  EXPECT_NO_THROW(hog[0]->expect_closed());
  second.status();
  hog[1]->status();
  hog[2]->status();
}

TEST_F(Transport, APortInUseIsOneClearError) {
  CrclServerOptions options;
  options.listener.port = port_;
  CrclServer second(options, world_, world_);
  const Result<std::uint16_t> port = second.start();
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error().field, "crcl.fanuc");
  EXPECT_EQ(port.error().message, "cannot listen on 127.0.0.1 port " + std::to_string(port_) +
                                      ": Address already in use");
}

TEST_F(Transport, AHostNameOtherThanLocalhostIsRefused) {
  CrclServerOptions options;
  options.listener.address = "cell.lab";
  CrclServer server(options, world_, world_);
  const Result<std::uint16_t> port = server.start();
  ASSERT_FALSE(port);
  EXPECT_NE(port.error().message.find("neither a numeric"), std::string::npos);
}

TEST_F(Transport, StopClosesEverything) {
  TestClient client(port_);
  client.status();
  server_->stop();
  client.expect_closed();
  EXPECT_THROW(TestClient{port_}, std::runtime_error);
  server_->stop();
}

TEST_F(Transport, StopIsNotHeldUpByADeafPeer) {
  CrclServerOptions options;
  options.write_timeout = std::chrono::minutes(1);
  options.listener.drain_deadline = std::chrono::milliseconds(100);
  start(options);
  TestClient deaf(port_, 4096);
  std::string packet;
  for (int i = 0; i < 3000; ++i) packet += get_status_;
  deaf.send(packet.substr(0, packet.size() / 2));
  TestClient(port_).status();
  const auto before = std::chrono::steady_clock::now();
  server_->stop();
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(20));
}

TEST_F(Transport, APortCanBeUsedAgainAtOnce) {
  for (int i = 0; i < 3; ++i) {
    TestClient client(port_);
    client.status();
    server_->stop();
    CrclServerOptions options;
    options.listener.port = port_;
    server_ = std::make_unique<CrclServer>(options, world_, world_);
    ASSERT_TRUE(server_->start());
  }
}

TEST_F(Transport, TheSecondRobotHasItsOwnState) {
  CrclServerOptions options;
  options.listener.port = 0;
  options.robot = 1;
  CrclServer motoman(options, world_, world_);
  const std::uint16_t port = motoman.start().value();
  TestClient first(port_);
  TestClient second(port);
  initialize(first);
  expect(second.status(), -1, CommandState::kReady);
  EXPECT_EQ(second.status().joints.size(), 7U);
  second.command(9, "InitCanonType");
  ticket(2);
  EXPECT_EQ(std::get<api::RobotCommand>(world_.commands()[1].body).robot, 1);
  expect(first.status(), 4, CommandState::kDone);
}

}  // namespace
}  // namespace aprsim::crcl_server
