// Many clients of one robot at once, some of them misbehaving, against the real daemon in real
// time.

#include <chrono>
#include <csignal>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/crcl_text_client.hpp"
#include "tests/support/daemon_process.hpp"

namespace aprsim::test {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kSockets = 64;

std::string raise(const std::string& status, double by_mm) {
  const auto vector = [&](const std::string& name) {
    const auto at = status.find("<" + name + ">");
    return status.substr(at, status.find("</" + name + ">") - at) + "</" + name + ">";
  };
  const double z = CrclTextClient::number(status, "Z") + by_mm;
  return "<MoveStraight>true</MoveStraight><EndPosition><Point><X>" +
         CrclTextClient::field(status, "X") + "</X><Y>" + CrclTextClient::field(status, "Y") +
         "</Y><Z>" + std::to_string(z) + "</Z></Point>" + vector("XAxis") + vector("ZAxis") +
         "</EndPosition>";
}

/// Floods the robot with requests and never reads an answer, until it is thrown out.
void ask_and_never_listen(CrclTextClient& deaf) {
  const std::string one = CrclTextClient::document("GetStatusType", 1);
  std::string packet;
  for (int i = 0; i < 1000; ++i) packet += one;
  try {
    for (int i = 0; i < 500; ++i) deaf.raw(packet);
  } catch (const std::exception&) {
    return;
  }
  ADD_FAILURE() << "100 MB of requests were taken and none of their answers";
}

TEST(CrclCrowd, SixtyFourSocketsOfWhichSomeMisbehave) {
  DaemonProcess daemon({"--scene", "fanuc_only"});
  const std::uint16_t port = daemon.port("crcl.fanuc");
  auto mover = std::make_unique<CrclTextClient>(port);
  CrclTextClient deaf(port), half(port);
  std::vector<std::unique_ptr<CrclTextClient>> pollers;
  while (pollers.size() + 3 < kSockets) pollers.push_back(std::make_unique<CrclTextClient>(port));
  CrclTextClient& watcher = *pollers.front();
  // A client that has sent no request would be evicted for the new one.
  for (const auto& poller : pollers) poller->status();
  for (CrclTextClient* other : {mover.get(), &deaf, &half}) other->status();
  EXPECT_THROW(CrclTextClient(port).status(), std::exception) << "one too many";

  mover->run("InitCanonType");
  mover->run("SetTransSpeedType",
             "<TransSpeed xsi:type=\"TransSpeedAbsoluteType\"><Setting>20</Setting></TransSpeed>");
  const std::string start = mover->status();
  const auto move = mover->send("MoveToType", raise(start, -160));
  EXPECT_EQ(CrclTextClient::field(mover->status(), "CommandState"), "CRCL_Working");
  const std::string stop =
      CrclTextClient::document("StopMotionType", 77, "<StopCondition>Fast</StopCondition>");
  half.raw(stop.substr(0, stop.size() / 2));
  std::jthread flood([&] { ask_and_never_listen(deaf); });
  mover->vanish();

  // Every poller is answered, each within its client's patience.
  std::string status;
  const auto deadline = Clock::now() + std::chrono::seconds(30);
  do {
    for (const auto& poller : pollers) status = poller->status();
  } while (CrclTextClient::field(status, "CommandState") == "CRCL_Working" &&
           Clock::now() < deadline);
  EXPECT_EQ(CrclTextClient::field(status, "CommandID"), std::to_string(move));
  // The mover was reset: the robot stops with an error, as a killed controller's does.
  EXPECT_EQ(CrclTextClient::field(status, "CommandState"), "CRCL_Error") << status;
  EXPECT_NE(status.find("was lost"), std::string::npos) << status;
  EXPECT_GT(CrclTextClient::number(status, "Z"), CrclTextClient::number(start, "Z") - 160 + 1);
  flood.join();
  watcher.status();
  watcher.run("InitCanonType");
  half.raw(stop.substr(stop.size() / 2));
  half.wait_done(77);

  const ProcessResult ended = daemon.stop(SIGTERM);
  const std::string log = ended.out + ended.err;
  EXPECT_NE(log.find("it did not take its pending statuses in time"), std::string::npos) << log;
}

}  // namespace
}  // namespace aprsim::test
