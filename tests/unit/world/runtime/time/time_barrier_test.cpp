#include "world/runtime/time/time_barrier.hpp"

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

using namespace std::chrono_literals;
using Ids = std::vector<api::PacerId>;
using Names = std::vector<std::string>;

const WallTime kBegin{};

api::PacerRole role_of(const std::string& name, api::PacerKind kind = api::PacerKind::kClient,
                       api::EndpointId endpoint = 16) {
  return {.name = name, .kind = kind, .endpoint = endpoint};
}

api::PacerId join(TimeBarrier& barrier, const std::string& name, WallTime now = kBegin,
                  api::PacerKind kind = api::PacerKind::kClient, api::EndpointId endpoint = 16) {
  const auto id = barrier.join(role_of(name, kind, endpoint), now);
  EXPECT_TRUE(id) << name;
  return id.value_or(0);
}

/// Takes all the steps that are due; who is reached then at first.
Ids take_due(TimeBarrier& barrier, WallTime now = kBegin) {
  for (auto steps = barrier.due(); steps > 0; --steps) barrier.step();
  return barrier.take_reached(now);
}

/// The same with those that are reached once the ones before have asked for another `steps`.
Ids take_due_in_turn(TimeBarrier& barrier, TimeBarrier::Steps steps, WallTime now = kBegin) {
  Ids all;
  for (Ids reached = take_due(barrier, now); !reached.empty();
       reached = barrier.take_reached(now)) {
    EXPECT_EQ(reached.size(), 1U);
    all.push_back(reached.front());
    barrier.request_until(reached.front(), steps);
  }
  return all;
}

TEST(TimeBarrier, OneClientsPollsAreTheClock) {
  TimeBarrier barrier({});
  EXPECT_FALSE(barrier.paced()) << "nobody is there";
  const auto fanuc = join(barrier, "crcl.fanuc");
  EXPECT_TRUE(barrier.paced());
  EXPECT_EQ(barrier.due(), 0U) << "it has not asked";
  for (unsigned poll = 1; poll <= 3; ++poll) {
    barrier.request_until(fanuc, 25);
    EXPECT_EQ(barrier.due(), 25U);
    EXPECT_EQ(take_due(barrier), Ids{fanuc});
    EXPECT_EQ(barrier.now(), 25 * poll);
    EXPECT_EQ(barrier.due(), 0U);
  }
}

TEST(TimeBarrier, TimeGoesToTheLeastThatAllHaveAskedFor) {
  TimeBarrier barrier({});
  const auto fanuc = join(barrier, "crcl.fanuc"), motoman = join(barrier, "crcl.motoman"),
             plc = join(barrier, "modbus");
  barrier.request_until(fanuc, 25);
  barrier.request_until(plc, 10);
  EXPECT_EQ(barrier.due(), 0U) << "motoman's client thinks";
  barrier.request_until(motoman, 25);
  EXPECT_EQ(take_due(barrier), Ids{plc});
  EXPECT_EQ(barrier.now(), 10U);
  EXPECT_EQ(barrier.due(), 0U);
  barrier.request_until(plc, 40);
  EXPECT_EQ(take_due_in_turn(barrier, 25), (Ids{fanuc, motoman}));
  EXPECT_EQ(barrier.now(), 25U);
  barrier.leave(motoman, kBegin);
  EXPECT_EQ(take_due_in_turn(barrier, 25), (Ids{fanuc, plc})) << "who has left is not waited for";
  EXPECT_EQ(barrier.now(), 50U);
}

TEST(TimeBarrier, OneThinksAtATimeInTheOrderOfEndpoints) {
  TimeBarrier barrier({});
  const auto motoman = join(barrier, "crcl.motoman", kBegin, api::PacerKind::kClient, 17);
  const auto fanuc = join(barrier, "crcl.fanuc", kBegin, api::PacerKind::kClient, 16);
  barrier.request_until(fanuc, 25);
  barrier.request_until(motoman, 25);
  EXPECT_EQ(take_due(barrier), Ids{fanuc});
  EXPECT_EQ(barrier.take_reached(kBegin), Ids{}) << "it thinks";
  barrier.request_until(fanuc, 25);
  EXPECT_EQ(barrier.due(), 0U) << "the other one stands here still";
  EXPECT_EQ(barrier.take_reached(kBegin), Ids{motoman});
  barrier.request_until(motoman, 25);
  EXPECT_EQ(barrier.due(), 25U);
}

TEST(TimeBarrier, DeclaredPacersAreWaitedForAtTheBeginning) {
  TimeBarrier barrier({.declared = {"crcl.fanuc", "crcl.motoman"}, .grace = 1s});
  EXPECT_TRUE(barrier.paced());
  const auto fanuc = join(barrier, "crcl.fanuc");
  barrier.request_until(fanuc, 25);
  barrier.expire(kBegin + 1h);
  EXPECT_EQ(barrier.due(), 0U) << "however long it takes";
  EXPECT_EQ(barrier.state(kBegin).awaited, Names{"crcl.motoman"});
  EXPECT_FALSE(barrier.join(role_of("modbus"), kBegin)) << "not declared";
  EXPECT_FALSE(barrier.join(role_of("crcl.fanuc"), kBegin)) << "the place is taken";
  const auto motoman = join(barrier, "crcl.motoman", kBegin + 1h);
  barrier.request_until(motoman, 5);
  EXPECT_EQ(take_due(barrier), Ids{motoman});
  EXPECT_TRUE(barrier.state(kBegin + 1h).reproducible());
}

TEST(TimeBarrier, ADeclaredPacerThatIsAwayHoldsTime) {
  TimeBarrier barrier({.declared = {"crcl.fanuc", "crcl.motoman"}});
  const auto fanuc = join(barrier, "crcl.fanuc"), motoman = join(barrier, "crcl.motoman");
  barrier.request_until(fanuc, 25);
  barrier.leave(motoman, kBegin);
  barrier.expire(kBegin + 1h);
  EXPECT_EQ(barrier.due(), 0U) << "no grace time";
  const auto again = join(barrier, "crcl.motoman");
  barrier.request_until(again, 25);
  EXPECT_EQ(take_due_in_turn(barrier, 25), (Ids{fanuc, again}));
  EXPECT_TRUE(barrier.state(kBegin).reproducible());
  barrier.leave(fanuc, kBegin);
  barrier.leave(again, kBegin);
  EXPECT_TRUE(barrier.paced()) << "never by the wall clock";
  EXPECT_EQ(barrier.due(), 0U);
}

TEST(TimeBarrier, DropsAndCountsASilentPacer) {
  TimeBarrier barrier({.declared = {"crcl.fanuc", "crcl.motoman"}, .grace = 2s});
  const auto fanuc = join(barrier, "crcl.fanuc"), motoman = join(barrier, "crcl.motoman");
  barrier.expire(kBegin + 1h);
  EXPECT_TRUE(barrier.state(kBegin + 1h).reproducible()) << "nobody has waited";
  barrier.request_until(fanuc, 25);
  barrier.request_until(motoman, 25);
  ASSERT_EQ(take_due(barrier, kBegin + 1h), Ids{fanuc});
  barrier.request_until(fanuc, 25);
  ASSERT_EQ(barrier.take_reached(kBegin + 1h), Ids{motoman});
  barrier.expire(kBegin + 1h + 1900ms);
  EXPECT_EQ(barrier.due(), 0U);
  EXPECT_EQ(barrier.state(kBegin + 1h + 1900ms).awaited, Names{"crcl.motoman"});
  barrier.expire(kBegin + 1h + 2s);
  EXPECT_EQ(take_due(barrier, kBegin + 1h + 2s), Ids{fanuc});
  EXPECT_EQ(barrier.state(kBegin).expired, 1U);
  EXPECT_FALSE(barrier.state(kBegin).reproducible());
  // When it asks again it belongs to them again.
  barrier.request_until(motoman, 10);
  barrier.request_until(fanuc, 25);
  EXPECT_EQ(take_due(barrier, kBegin + 1h + 3s), Ids{motoman});
  EXPECT_EQ(barrier.now(), 60U);
}

TEST(TimeBarrier, APlaceThatStaysEmptyIsGivenUpAfterTheGraceTime) {
  TimeBarrier barrier({.declared = {"crcl.fanuc", "crcl.motoman"}, .grace = 2s});
  const auto fanuc = join(barrier, "crcl.fanuc"), motoman = join(barrier, "crcl.motoman");
  barrier.leave(motoman, kBegin);
  barrier.request_until(fanuc, 25);
  barrier.expire(kBegin + 1s);
  EXPECT_EQ(barrier.due(), 0U);
  barrier.expire(kBegin + 2s);
  EXPECT_EQ(barrier.due(), 25U);
  EXPECT_EQ(barrier.state(kBegin).expired, 1U);
  join(barrier, "crcl.motoman");
  EXPECT_EQ(barrier.due(), 0U) << "it is back";
}

TEST(TimeBarrier, DoesNotWaitForAnExcludedPacer) {
  TimeBarrier barrier({.declared = {"crcl.fanuc", "crcl.motoman"}});
  const auto fanuc = join(barrier, "crcl.fanuc"), motoman = join(barrier, "crcl.motoman");
  barrier.request_until(fanuc, 25);
  barrier.exclude(motoman);
  barrier.leave(motoman, kBegin);
  EXPECT_EQ(barrier.due(), 25U);
  EXPECT_EQ(barrier.state(kBegin).expired, 1U);
  join(barrier, "crcl.motoman");
  EXPECT_EQ(barrier.due(), 0U);
}

TEST(TimeBarrier, NobodyIsLeftBehindForWhoHasFinished) {
  TimeBarrier barrier({.declared = {"crcl.fanuc", "crcl.motoman"}, .grace = 2s});
  const auto fanuc = join(barrier, "crcl.fanuc");
  join(barrier, "crcl.motoman");
  barrier.request_until(fanuc, 25);
  barrier.finish(fanuc);
  barrier.expire(kBegin + 1h);
  EXPECT_EQ(barrier.due(), 0U);
  EXPECT_TRUE(barrier.state(kBegin + 1h).reproducible());
}

TEST(TimeBarrier, TheWallClockTakesOverWhenNobodyPaces) {
  TimeBarrier barrier({.grace = 2s});
  EXPECT_EQ(barrier.state(kBegin).fallbacks, 1U);
  const auto fanuc = join(barrier, "crcl.fanuc");
  EXPECT_TRUE(barrier.paced());
  barrier.expire(kBegin + 1s);
  EXPECT_TRUE(barrier.paced());
  barrier.expire(kBegin + 2s);
  EXPECT_FALSE(barrier.paced()) << "the only client is silent";
  EXPECT_EQ(barrier.state(kBegin).fallbacks, 2U);
  EXPECT_EQ(barrier.state(kBegin).pacers, Names{});
  barrier.request_until(fanuc, 25);
  EXPECT_TRUE(barrier.paced());
  barrier.leave(fanuc, kBegin);
  EXPECT_FALSE(barrier.paced());
  EXPECT_EQ(barrier.state(kBegin).fallbacks, 3U);
}

TEST(TimeBarrier, FramesAreHandedOnBeforeClientsAreAnswered) {
  TimeBarrier barrier({});
  const auto fanuc = join(barrier, "crcl.fanuc"), motoman = join(barrier, "crcl.motoman");
  const auto feed = join(barrier, "vision.fanuc", kBegin, api::PacerKind::kFeed);
  barrier.request_until(fanuc, 25);
  barrier.request_until(motoman, 30);
  EXPECT_EQ(barrier.due(), 0U) << "the feed has not asked";
  barrier.request_until(feed, 0);
  ASSERT_EQ(barrier.due(), 25U);
  for (int i = 0; i < 25; ++i) barrier.step();
  barrier.cut(feed);
  EXPECT_EQ(barrier.take_reached(kBegin), Ids{feed});
  EXPECT_EQ(barrier.take_reached(kBegin), Ids{}) << "the frame is on its way";
  EXPECT_EQ(barrier.due(), 0U);
  barrier.request_until(feed, 250);
  EXPECT_EQ(barrier.take_reached(kBegin), Ids{fanuc});
  barrier.expire(kBegin + 1h);
  EXPECT_TRUE(barrier.paced()) << "no grace time";
}

TEST(TimeBarrier, ProgramsPaceButAreNoClients) {
  TimeBarrier barrier({});
  const auto program = join(barrier, "program", kBegin, api::PacerKind::kProgram);
  barrier.request_until(program, 1);
  EXPECT_FALSE(barrier.paced());
  const auto fanuc = join(barrier, "crcl.fanuc");
  barrier.request_until(fanuc, 25);
  EXPECT_EQ(barrier.due(), 1U);
  EXPECT_EQ(take_due(barrier), Ids{program});
  EXPECT_EQ(barrier.endpoints(), (std::vector<api::EndpointId>{16, 16}));
}

TEST(TimeBarrier, NobodyWaitsForAPausedCell) {
  TimeBarrier barrier({});
  const auto fanuc = join(barrier, "crcl.fanuc");
  const auto feed = join(barrier, "vision.fanuc", kBegin, api::PacerKind::kFeed);
  barrier.request_until(feed, 0);
  barrier.request_until(fanuc, 25);
  EXPECT_EQ(barrier.release_clients(kBegin), Ids{fanuc});
  EXPECT_EQ(barrier.release_clients(kBegin), Ids{});
  EXPECT_EQ(barrier.now(), 0U);
}

TEST(TimeBarrier, RolesOfRobotsThatHaveLeftAreNotWaitedFor) {
  TimeBarrier barrier({.declared = {"crcl.fanuc", "crcl.motoman", "modbus"}});
  const auto fanuc = join(barrier, "crcl.fanuc"), motoman = join(barrier, "crcl.motoman");
  const auto belt = join(barrier, "modbus");
  for (const auto id : {fanuc, motoman, belt}) barrier.request_until(id, 25);
  EXPECT_EQ(barrier.due(), 25U);
  barrier.set_robots({"motoman"}, kBegin);
  // Its connection is still open and does not count.
  EXPECT_EQ(barrier.state(kBegin).pacers, (Names{"crcl.motoman", "modbus"}));
  barrier.leave(fanuc, kBegin);
  EXPECT_EQ(barrier.due(), 25U);
  EXPECT_TRUE(barrier.state(kBegin).awaited.empty());
  // The robot is back, and time waits for its client.
  barrier.set_robots({"fanuc", "motoman"}, kBegin);
  EXPECT_EQ(barrier.due(), 0U);
  EXPECT_EQ(barrier.state(kBegin).awaited, Names{"crcl.fanuc"});
  const auto again = join(barrier, "crcl.fanuc");
  barrier.request_until(again, 10);
  EXPECT_EQ(barrier.due(), 10U);
  EXPECT_EQ(barrier.state(kBegin).fallbacks, 0U);
}

TEST(TimeBarrier, AnyClientPacesWhileNoDeclaredRobotIsThere) {
  TimeBarrier barrier({.declared = {"crcl.fanuc"}});
  const auto fanuc = join(barrier, "crcl.fanuc");
  barrier.request_until(fanuc, 5);
  EXPECT_EQ(take_due(barrier), Ids{fanuc});
  barrier.set_robots({"ur5e", "scara"}, kBegin);
  barrier.leave(fanuc, kBegin);
  EXPECT_TRUE(barrier.paced()) << "time does not fall back to the wall clock";
  EXPECT_EQ(barrier.due(), 0U);
  EXPECT_EQ(barrier.state(kBegin).awaited, Names{"any client"});
  const auto scara = join(barrier, "crcl.scara", kBegin, api::PacerKind::kClient, 17);
  EXPECT_TRUE(barrier.state(kBegin).awaited.empty());
  barrier.request_until(scara, 25);
  EXPECT_EQ(barrier.due(), 25U);
  EXPECT_EQ(take_due(barrier), Ids{scara});
  // A client that joined then does not pace beside the declared ones.
  barrier.set_robots({"fanuc", "scara"}, kBegin);
  EXPECT_EQ(barrier.due(), 0U);
  EXPECT_EQ(barrier.state(kBegin).awaited, Names{"crcl.fanuc"});
  const auto again = join(barrier, "crcl.fanuc");
  barrier.request_until(again, 3);
  EXPECT_EQ(barrier.due(), 3U);
  EXPECT_EQ(barrier.state(kBegin).pacers, Names{"crcl.fanuc"});
  EXPECT_EQ(barrier.state(kBegin).fallbacks, 0U);
}

TEST(TimeBarrier, AClientThatPacedWithoutARoleTakesItsPlace) {
  TimeBarrier barrier({.declared = {"crcl.fanuc", "crcl.scara"}});
  barrier.set_robots({"ur5e"}, kBegin);
  const auto first = join(barrier, "crcl.ur5e");
  barrier.set_robots({"scara", "ur5e"}, kBegin);
  EXPECT_FALSE(barrier.join(role_of("crcl.ur5e"), kBegin));
  const auto scara = join(barrier, "crcl.scara");
  barrier.request_until(scara, 25);
  EXPECT_EQ(take_due(barrier), Ids{scara}) << "the first one does not pace";
  barrier.leave(first, kBegin);
  barrier.set_robots({"ur5e"}, kBegin);
  const auto other = join(barrier, "crcl.fanuc", kBegin, api::PacerKind::kClient, 18);
  barrier.set_robots({"fanuc"}, kBegin);
  barrier.request_until(other, 4);
  EXPECT_EQ(barrier.due(), 4U);
  EXPECT_EQ(barrier.state(kBegin).pacers, Names{"crcl.fanuc"});
}

}  // namespace
}  // namespace aprsim::world
