#include "clients/wires/vision_feed.hpp"

#include <gtest/gtest.h>

#include "tests/unit/clients/wires/listener.hpp"

namespace aprsim::client {
namespace {

using namespace std::chrono_literals;

Endpoints camera_at(std::uint16_t port) {
  Endpoints endpoints;
  endpoints.vision = {{"fanuc", port}};
  return endpoints;
}

TEST(VisionFeed, ReadsFramesInAnySegmentation) {
  test::Listener listener;
  auto feed = VisionFeed::connect(camera_at(listener.port()), "fanuc");
  ASSERT_TRUE(feed) << feed.error().message;
  listener.send("a,0,1,2,1,P,\nb,0,1,2,1,P,c,0,1");
  const auto first = feed->next(10s);
  ASSERT_TRUE(first) << first.error().message;
  ASSERT_EQ(first->size(), 1U);
  EXPECT_EQ(first->front().name, "a");
  listener.send(",2,1,P,\n");
  const auto second = feed->next(10s);
  ASSERT_TRUE(second) << second.error().message;
  ASSERT_EQ(second->size(), 2U);
  EXPECT_EQ(second->back().name, "c");
}

TEST(VisionFeed, EndsWhenItIsCancelledAndWhenTheCameraIsGone) {
  test::Listener listener;
  bool enough = false;
  auto feed = VisionFeed::connect(camera_at(listener.port()), "fanuc", [&] { return enough; });
  ASSERT_TRUE(feed) << feed.error().message;
  listener.send("a,0");
  enough = true;
  EXPECT_EQ(feed->next(1h).error().kind, FailureKind::kInterrupted);
  enough = false;
  listener.hang_up();
  EXPECT_EQ(feed->next(1h).error().kind, FailureKind::kConnection);
}

TEST(VisionFeed, KnowsTheRobotsThatHaveACamera) {
  const auto feed = VisionFeed::connect(camera_at(1), "motoman");
  ASSERT_FALSE(feed);
  EXPECT_EQ(feed.error().kind, FailureKind::kUsage);
  EXPECT_EQ(feed.error().message, "no robot 'motoman'; there is fanuc");
}

}  // namespace
}  // namespace aprsim::client
