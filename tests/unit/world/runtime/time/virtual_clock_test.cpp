#include "world/runtime/time/virtual_clock.hpp"

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

using namespace std::chrono_literals;

// A call that is answered by a snapshot may be followed by the next one before the clock has been
// told that the snapshot is out.
TEST(VirtualClock, CountsARequestFromItsSnapshotOn) {
  VirtualClock clock({.pacers = {"grpc", "crcl.fanuc"}, .grace = 0s}, 1ms, [] {});
  int reached = 0;
  const auto grpc = clock.join({.name = "grpc"}, [] {});
  const auto fanuc = clock.join({.name = "crcl.fanuc", .endpoint = 16}, [&] { ++reached; });
  ASSERT_TRUE(grpc && fanuc);
  clock.request_until(*grpc, 3ms);
  clock.request_until(*fanuc, 3ms);
  const api::Snapshot snapshot;
  for (TimeBarrier::Steps left = 3; left > 0; --left) {
    EXPECT_EQ(clock.turn({}).due, left);
    clock.stepped();
    if (left == 1) clock.request_until(*grpc, 3ms);
    EXPECT_EQ(reached, 0) << "before the snapshot is out";
    EXPECT_EQ(clock.published(snapshot, {}), left > 1);
  }
  EXPECT_EQ(reached, 1);
  EXPECT_EQ(clock.turn({}).due, 0U);
  clock.request_until(*fanuc, 25ms);
  EXPECT_EQ(clock.turn({}).due, 3U);
}

// A feed of states has no camera whose frames could end its request early.
TEST(VirtualClock, AFeedWithoutFramesKeepsItsPeriod) {
  VirtualClock clock({.pacers = {"crcl.fanuc"}, .grace = 0s}, 1ms, [] {});
  int reached = 0;
  const auto feed =
      clock.join({.name = "state.fanuc", .kind = api::PacerKind::kFeed}, [&] { ++reached; });
  const auto client = clock.join({.name = "crcl.fanuc", .endpoint = 16}, [] {});
  ASSERT_TRUE(feed && client);
  clock.request_until(*feed, 24ms);
  clock.request_until(*client, 25ms);
  const api::Snapshot snapshot;
  for (int step = 1; step <= 24; ++step) {
    EXPECT_EQ(reached, 0) << step;
    clock.stepped();
    clock.published(snapshot, {});
  }
  EXPECT_EQ(reached, 1);
}

}  // namespace
}  // namespace aprsim::world
