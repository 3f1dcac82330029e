#include "protocols/vision/vision_server.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/eventually.hpp"
#include "tests/support/fake_cell.hpp"
#include "tests/support/vision_client.hpp"

namespace aprsim::vision_server {
namespace {

using namespace std::chrono_literals;
using test::eventually;
using test::VisionClient;
using Clock = std::chrono::steady_clock;

std::shared_ptr<const api::CellDescription> cell_of_gears(int count) {
  auto cell = std::make_shared<api::CellDescription>(*test::two_robot_cell());
  for (int i = 0; i < count; ++i) cell->bodies.emplace_back().type = "sku_part_small_gear";
  return cell;
}

/// A server of the first robot on a free port, fed by hand.
class VisionServerTest : public testing::Test {
 protected:
  explicit VisionServerTest(int gears = 2)
      : gears_(gears), world(test::FakeCell::Commands::kHeld, test::at_rest(cell_of_gears(gears))) {
    options.listener.port = 0;
  }
  std::uint16_t start() {
    server.emplace(options, world);
    return server->start().value();
  }
  /// The next frame: all gears at x = `millimetres`.
  void frame(double millimetres) {
    world.publish([&](api::Snapshot& next) {
      auto& vision = next.robots[0].vision;
      ++vision.number;
      vision.detections.clear();
      for (int i = 0; i < gears_; ++i) {
        vision.detections.push_back({i, millimetres / 1e3, 0, 0, 1});
      }
    });
  }
  static double x(const std::string& line) { return test::parse_vision_line(line).at(0).x_mm; }

  int gears_;
  test::FakeCell world;
  VisionServerOptions options;
  std::optional<VisionServer> server;
};

TEST_F(VisionServerTest, AClientGetsTheLatestFrameAndThenEachNewOne) {
  options.repeat = 10s;
  frame(10);
  VisionClient client(start());
  EXPECT_EQ(x(client.line()), 10);
  for (const double next : {20, 30, 40}) {
    frame(next);
    EXPECT_EQ(x(client.line()), next);
  }
  EXPECT_GE(server->stats().frames, 4U);
}

TEST_F(VisionServerTest, ANewFrameIsOutWithinMilliseconds) {
  options.repeat = 10s;
  frame(0);
  VisionClient client(start());
  std::vector<double> delays;
  client.line();
  for (int i = 1; i <= 20; ++i) {
    const auto before = Clock::now();
    frame(i);
    ASSERT_EQ(x(client.line()), i);
    delays.push_back(std::chrono::duration<double>(Clock::now() - before).count());
  }
  std::sort(delays.begin(), delays.end());
  EXPECT_LT(delays[delays.size() / 2], 0.05) << "median, with a poll each 5 ms";
}

TEST_F(VisionServerTest, AStandingCellRepeatsItsFrameAtLeastEveryHalfSecond) {
  frame(10);
  VisionClient client(start());
  const std::string first = client.line();
  constexpr int kRepeats = 4;
  // A busy machine may be late now and then, not always.
  EXPECT_TRUE(eventually([&] {
    EXPECT_EQ(client.line(), first);
    const auto before = Clock::now();
    for (int i = 0; i < kRepeats; ++i) EXPECT_EQ(client.line(), first);
    const auto span = Clock::now() - before;
    return span < kRepeats * 500ms && span > kRepeats * 200ms;
  })) << "as often as needed and no more";
  EXPECT_EQ(server->stats().frames, 1U) << "repetitions are no new frames";
}

TEST_F(VisionServerTest, AResetShowsEvenWithTheSameFrameNumber) {
  options.repeat = 10s;
  frame(10);
  VisionClient client(start());
  EXPECT_EQ(x(client.line()), 10);
  world.publish([](api::Snapshot& next) {
    ++next.epoch;
    next.robots[0].vision.detections[0].x_m = 0.05;
  });
  EXPECT_EQ(x(client.line()), 50);
}

TEST_F(VisionServerTest, AnEmptyFrameIsABlankLine) {
  VisionClient client(start());
  EXPECT_EQ(client.line(), "\n");
}

TEST_F(VisionServerTest, EmptySlotsAreNamedWhenConfigured) {
  options.empty_slots = true;
  VisionClient client(start());
  EXPECT_EQ(client.line(), "sku_part_small_gear,,,,,P,sku_part_small_gear,,,,,P,\n");
}

TEST_F(VisionServerTest, ManyClientsGetTheSameAndOneTooManyIsClosed) {
  options.listener.limits.at_once = 20;
  const auto port = start();
  std::vector<std::unique_ptr<VisionClient>> clients;
  for (int i = 0; i < 20; ++i) {
    clients.push_back(std::make_unique<VisionClient>(port));
    clients.back()->line();
  }
  VisionClient extra(port);
  EXPECT_TRUE(extra.closed(5s));
  frame(77);
  for (auto& client : clients) EXPECT_EQ(x(client->line_after("\n")), 77);
  EXPECT_EQ(server->stats().refused, 1U);
  clients.resize(10);
  EXPECT_TRUE(eventually([&] {
    frame(78);  // a gone peer shows when something is sent to it
    return server->stats().open == 10;
  }));
}

TEST_F(VisionServerTest, IgnoresInputAndServesHalfClosedClients) {
  options.repeat = 10s;
  VisionClient client(start());
  client.say("is anybody there?\r\n");
  client.line();
  client.finish_sending();
  frame(5);
  EXPECT_EQ(x(client.line_after("\n")), 5);
  frame(6);
  EXPECT_EQ(x(client.line()), 6);
}

/// Any web page can make its reader's browser send this.
TEST_F(VisionServerTest, BrowsersAreSentAway) {
  const auto port = start();
  VisionClient client(port);
  for (const std::string& bytes :
       {std::string("GET / HTTP/1.1\r\nHost: a\r\n\r\n"), std::string("POST / HTTP/1.1\r\n\r\nx"),
        std::string("\x16\x03\x01\x02\x00", 5)}) {
    VisionClient browser(port);
    browser.say(bytes);
    EXPECT_TRUE(browser.closed(10s));
  }
  EXPECT_EQ(server->stats().dropped, 3U);
  frame(5);
  EXPECT_EQ(x(client.line_after("\n")), 5);
}

TEST_F(VisionServerTest, ATableFullOfOneAddressHasAPlaceForAnother) {
  options.listener.limits.at_once = 3;
  const auto port = start();
  std::vector<std::unique_ptr<VisionClient>> hog;
  for (int i = 0; i < 3; ++i) {
    hog.push_back(std::make_unique<VisionClient>(port));
    hog.back()->line();
  }
  VisionClient same(port);
  EXPECT_TRUE(same.closed(10s));
  // The place that is kept, and then one of the address that has most.
  VisionClient second(port, 0, "127.0.0.2");
  second.line();
  VisionClient third(port, 0, "127.0.0.3");
  third.line();
  EXPECT_TRUE(eventually([&] { return server->stats().dropped == 1; }));
  EXPECT_EQ(server->stats().open, 4U);
}

/// Lines of some 40 kB, so that a client that does not read fills its buffers soon.
class VisionServerLongLines : public VisionServerTest {
 protected:
  VisionServerLongLines() : VisionServerTest(800) {}
};

TEST_F(VisionServerLongLines, AClientThatNeverReadsIsDroppedAndDelaysNobody) {
  options.write_timeout = 1000ms;
  const auto port = start();
  VisionClient silent(port, 4096);
  VisionClient reader(port);
  std::string last = reader.line();
  int frames = 0, meanwhile = 0;
  const bool dropped = eventually([&] {
    frame(++frames);
    last = reader.line_after(last);
    EXPECT_EQ(x(last), frames);
    if (server->stats().skipped > 0 && server->stats().dropped == 0) ++meanwhile;
    return server->stats().dropped == 1;
  });
  EXPECT_TRUE(dropped);
  EXPECT_GT(meanwhile, 0) << "frames that came while the other one's buffers were full";
  EXPECT_TRUE(eventually([&] { return server->stats().open == 1; }));
}

TEST_F(VisionServerLongLines, ASlowReaderSkipsToTheLatestFrame) {
  options.write_timeout = 60s;
  const auto port = start();
  VisionClient slow(port, 4096);
  // Without reading: the buffers take some frames, the rest replace each other.
  int sent = 0;
  ASSERT_TRUE(eventually(
      [&] {
        frame(++sent);
        return server->stats().skipped > 10;
      },
      40s));
  int got = 0;
  double newest = 0;
  while (newest < sent) {
    const std::string line = slow.line();
    if (line == "\n") continue;
    const double number = x(line);
    EXPECT_GE(number, newest) << "never backwards";
    newest = number;
    ++got;
  }
  EXPECT_EQ(newest, sent) << "the last one is never lost";
  EXPECT_LT(got, sent - 5) << "old frames were left out";
}

TEST_F(VisionServerTest, StopClosesEverythingSoonAndTheAddressErrorNamesThePort) {
  options.write_timeout = 60s;
  const auto port = start();
  VisionClient client(port);
  client.line();
  VisionServerOptions taken = options;
  taken.listener.port = port;
  VisionServer second(taken, world);
  const auto refused = second.start();
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find(std::to_string(port)), std::string::npos);
  const auto before = Clock::now();
  server->stop();
  EXPECT_LT(Clock::now() - before, 20s);
  EXPECT_TRUE(client.closed(10s));
}

}  // namespace
}  // namespace aprsim::vision_server
