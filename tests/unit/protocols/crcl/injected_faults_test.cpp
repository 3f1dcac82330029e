// Effects of injected faults on a CRCL port, and its full recovery after they end.

#include "tests/support/injected_faults.hpp"

#include <string>

#include "protocols/ports/wire_faults.hpp"
#include "tests/support/eventually.hpp"
#include "tests/unit/protocols/crcl/server_fixture.hpp"

namespace aprsim::crcl_server {
namespace {

using namespace std::chrono_literals;
using faults::Kind;
using Clock = std::chrono::steady_clock;

class PortFault : public ServerTest {
 protected:
  test::InjectedFaultsOf faults_{world_};
  const std::string get_status_ = crcl::with_id("GetStatusType", "");
};

TEST_F(PortFault, ADropClosesAllConnectionsOnce) {
  TestClient one(port_), two(port_);
  one.status();
  two.status();
  faults_.begin(Kind::kCrclDrop, 1);
  one.status();
  faults_.begin(Kind::kCrclDrop, 0);
  one.expect_closed();
  two.expect_closed();
  TestClient again(port_);
  again.status();
  faults_.begin(Kind::kCrclLateStatus, 1);
  for (int i = 0; i < 20; ++i) again.status();
  EXPECT_EQ(server_->stats().dropped, 2U);
  faults_.begin(Kind::kCrclDrop, 0);
  again.expect_closed();
}

TEST(MomentaryFaults, HappenOnceAndNotAgainWithASavedState) {
  protocols::MomentaryFaults drops(Kind::kCrclDrop, 0);
  api::Snapshot now;
  EXPECT_FALSE(drops.happened(now));
  const auto with = [](std::uint64_t id, int robot) {
    api::InjectedFaults list;
    auto& fault = list.all.emplace_back();
    fault.id = id;
    fault.kind = Kind::kCrclDrop;
    fault.robot = robot;
    fault.begin_step = 1;
    return std::make_shared<const api::InjectedFaults>(list);
  };
  now.faults = with(1, 1);
  EXPECT_FALSE(drops.happened(now)) << "another robot's";
  now.faults = with(2, 0);
  EXPECT_TRUE(drops.happened(now));
  EXPECT_FALSE(drops.happened(now));
  now.epoch = 1;  // a reset: numbers begin anew
  EXPECT_TRUE(drops.happened(now));
  now.epoch = 2;
  now.loaded_state = std::make_shared<const std::string>("here");
  EXPECT_FALSE(drops.happened(now)) << "it was before the state was saved";
  now.faults = with(3, 0);
  EXPECT_TRUE(drops.happened(now));
}

TEST_F(PortFault, ARebootClosesThePortAndOpensItAgain) {
  TestClient client(port_);
  client.status();
  faults_.begin(Kind::kControllerReboot, 0);
  client.expect_closed();
  EXPECT_TRUE(test::eventually([&] {
    try {
      TestClient refused(port_);
      return false;
    } catch (const std::exception&) {
      return true;
    }
  }));
  faults_.end();
  EXPECT_TRUE(test::eventually([&] {
    try {
      TestClient again(port_);
      again.status();
      return true;
    } catch (const std::exception&) {
      return false;
    }
  }));
}

TEST_F(PortFault, ItEndsWhileThePortIsClosed) {
  TestClient client(port_);
  client.status();
  faults_.begin(Kind::kControllerReboot, 0);
  client.expect_closed();
  server_->stop();
}

TEST_F(PortFault, HalfADocumentComesAndTheEnd) {
  test::TcpSocket client(port_);
  ASSERT_TRUE(client.send(get_status_));
  std::string whole;
  while (whole.find("</CRCLStatus>") == std::string::npos) {
    whole += client.receive(Clock::now() + 10s);
  }
  faults_.begin(Kind::kCrclHalfDocument, 0);
  ASSERT_TRUE(client.send(get_status_));
  std::string half;
  for (std::string bytes; !(bytes = client.receive(Clock::now() + 10s)).empty();) half += bytes;
  EXPECT_GT(half.size(), whole.size() / 3);
  EXPECT_EQ(half.find("</CRCLStatus>"), std::string::npos) << half;
  faults_.end();
  TestClient again(port_);
  again.status();
}

TEST_F(PortFault, LateStatusesComeInOrderAndThenAtOnce) {
  TestClient client(port_);
  const auto first = client.status().command.status_id;
  faults_.begin(Kind::kCrclLateStatus, 0, {0.3});
  const auto asked = Clock::now();
  for (int i = 0; i < 3; ++i) client.send(get_status_);
  EXPECT_EQ(client.read_status().command.status_id, first + 1);
  EXPECT_GE(Clock::now() - asked, 300ms);
  EXPECT_EQ(client.read_status().command.status_id, first + 2);
  EXPECT_EQ(client.read_status().command.status_id, first + 3);
  client.send(get_status_);
  faults_.end();
  client.send(get_status_);
  EXPECT_EQ(client.read_status().command.status_id, first + 4);
  EXPECT_EQ(client.read_status().command.status_id, first + 5) << "not before the late one";
  EXPECT_EQ(client.status().command.status_id, first + 6);
}

TEST_F(PortFault, ListenerStillGetsLateStatuses) {
  TestClient client(port_);
  client.status();
  faults_.begin(Kind::kCrclLateStatus, 0, {0.2});
  client.send(get_status_);
  client.finish_sending();
  client.read_status();
  client.expect_closed();
}

TEST_F(PortFault, AnOldStatusIsOfTheCommandBefore) {
  TestClient client(port_);
  initialize(client);
  faults_.begin(Kind::kCrclOldStatus, 0);
  expect(client.status(), 4, CommandState::kDone);
  client.command(5, "DwellType", "<DwellTime>1</DwellTime>");
  ticket(2);
  const auto old = client.status();
  expect(old, 4, CommandState::kDone);
  EXPECT_EQ(client.status().command.status_id, old.command.status_id + 1) << "counts on";
  faults_.end();
  expect(client.status(), 5, CommandState::kWorking);
}

TEST_F(PortFault, ASlowPortTakesDocumentsOneByOne) {
  TestClient client(port_);
  client.status();
  faults_.begin(Kind::kCrclSlow, 0, {0.2});
  const auto sent = Clock::now();
  client.command(4, "InitCanonType");
  client.send(get_status_);
  EXPECT_EQ(client.read_status().command.command_id, 4);
  EXPECT_GE(Clock::now() - sent, 400ms);
  faults_.end();
  client.status();
  client.status();
}

TEST_F(PortFault, AClientThatLeavesASlowPortIsForgotten) {
  {
    TestClient client(port_);
    client.status();
    faults_.begin(Kind::kCrclSlow, 0, {5});
    client.command(4, "InitCanonType");
    EXPECT_TRUE(test::eventually([&] { return server_->stats().commands == 2; }));
    client.reset();
  }
  faults_.end();
  TestClient again(port_);
  again.status();
}

}  // namespace
}  // namespace aprsim::crcl_server
