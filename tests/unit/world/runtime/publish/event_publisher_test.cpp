#include "world/runtime/publish/event_publisher.hpp"

#include <gtest/gtest.h>

#include "tests/unit/world/runtime/fake_recorder.hpp"

namespace aprsim::world {
namespace {

TEST(EventPublisher, NumbersEventsOverEpochsAndReportsThemToTheRecorder) {
  test::FakeRecorder recorder;
  RunRecording recording(&recorder);
  EventPublisher publisher(recording);
  std::vector<api::CellEvent> found{{.step = 4}, {.step = 5}};
  publisher.assign_event_ids(found, 0);
  EXPECT_TRUE(found.empty());
  found.push_back({.step = 1});
  publisher.assign_event_ids(found, 1);
  ASSERT_EQ(publisher.pending().size(), 3U);
  EXPECT_EQ(publisher.pending()[2]->sequence, 3U);
  EXPECT_EQ(publisher.pending()[2]->epoch, 1U);
  EXPECT_EQ(publisher.last_event(), 3U);
  EXPECT_EQ(recorder.take(),
            (std::vector<std::string>{"happened 0.4 1", "happened 0.5 2", "happened 1.1 3"}));
}

TEST(EventPublisher, EventsAreInTheLogOnceTheyArePublished) {
  RunRecording recording(nullptr);
  EventPublisher publisher(recording);
  std::vector<api::CellEvent> found{{.step = 4}, {.step = 5}};
  publisher.assign_event_ids(found, 0);
  EXPECT_EQ(publisher.log().after(0, 10).latest, 0U);
  publisher.publish_events();
  EXPECT_TRUE(publisher.pending().empty());
  const auto batch = publisher.log().after(1, 10);
  ASSERT_EQ(batch.events.size(), 1U);
  EXPECT_EQ(batch.events[0]->sequence, 2U);
  EXPECT_EQ(batch.events[0]->step, 5U);
  publisher.publish_events();
  EXPECT_EQ(publisher.log().after(0, 10).events.size(), 2U) << "nothing twice";
}

}  // namespace
}  // namespace aprsim::world
