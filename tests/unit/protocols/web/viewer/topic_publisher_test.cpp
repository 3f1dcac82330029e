#include "protocols/web/viewer/topic_publisher.hpp"

#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace aprsim::web {
namespace {

using namespace std::chrono_literals;

/// Accepts one message, and each further one after take_next().
class FakeSocket final : public WebSocket {
 public:
  void start(Events events) override { events_ = std::move(events); }
  void write(WebMessage message) override { written.push_back(std::move(message)); }
  void close(const std::string&, bool) override {}
  void drop() override {}
  void take_next() { events_.written(); }

  std::vector<WebMessage> written;

 private:
  Events events_;
};

class TopicPublisherTest : public ::testing::Test {
 protected:
  FakeSocket& add_viewer(protocols::Role role = protocols::Role::kView) {
    const auto socket = std::make_shared<FakeSocket>();
    viewers_.push_back(std::make_shared<Viewer>(viewers_.size(), socket, "peer", Viewer::Events{}));
    viewers_.back()->role = role;
    viewers_.back()->start();
    return *socket;
  }
  /// A topic whose messages carry `text_` and whose revision is `revision_`.
  Topic topic() {
    return {.name = "test",
            .period = 100ms,
            .revision = [this] { return revision_; },
            .write =
                [this](v1::ViewerUpdate& update) {
                  ++built_;
                  update.mutable_welcome()->set_version(text_);
                }};
  }
  static std::string text_of(const WebMessage& message) {
    v1::ViewerUpdate update;
    EXPECT_TRUE(update.ParseFromString(*message));
    return update.welcome().version();
  }

  std::vector<std::shared_ptr<Viewer>> viewers_;
  Topic::Clock::time_point start_ = Topic::Clock::now();
  Topic::Revision revision_ = 1;
  std::string text_ = "first";
  int built_ = 0;
};

TEST_F(TopicPublisherTest, ViewersShareTheMessageOfARound) {
  FakeSocket& one = add_viewer();
  FakeSocket& other = add_viewer();
  TopicPublisher publisher({topic()});
  publisher.publish(viewers_, start_);
  ASSERT_EQ(one.written.size(), 1U);
  EXPECT_EQ(one.written, other.written);
  EXPECT_EQ(built_, 1);
}

TEST_F(TopicPublisherTest, ViewerGetsEachRevisionOnceAndNotBeforeItsRound) {
  FakeSocket& socket = add_viewer();
  TopicPublisher publisher({topic()});
  publisher.publish(viewers_, start_);
  socket.take_next();
  publisher.publish(viewers_, start_ + 100ms);
  EXPECT_EQ(socket.written.size(), 1U);
  revision_ = 2;
  text_ = "second";
  publisher.publish(viewers_, start_ + 150ms);
  EXPECT_EQ(socket.written.size(), 1U);
  publisher.publish(viewers_, start_ + 200ms);
  ASSERT_EQ(socket.written.size(), 2U);
  EXPECT_EQ(text_of(socket.written[1]), "second");
}

TEST_F(TopicPublisherTest, NewViewerWaitsForARoundUnlessTheTopicSaysOtherwise) {
  Topic at_once = topic();
  at_once.first_at_once = true;
  add_viewer();
  TopicPublisher publisher({topic(), at_once});
  publisher.publish(viewers_, start_);
  FakeSocket& late = add_viewer();
  publisher.publish(viewers_, start_ + 10ms);
  EXPECT_EQ(late.written.size(), 1U);
  late.take_next();
  publisher.publish(viewers_, start_ + 100ms);
  EXPECT_EQ(late.written.size(), 2U);
}

TEST_F(TopicPublisherTest, RoleAndWishDecideWhoGetsIt) {
  Topic watched = topic();
  watched.wanted = [](const Audience& viewer) { return viewer.watch.registers(); };
  FakeSocket& stranger = add_viewer(protocols::Role::kNone);
  FakeSocket& other = add_viewer();
  FakeSocket& watcher = add_viewer();
  viewers_[0]->watch.set_registers(true);
  viewers_[2]->watch.set_registers(true);
  TopicPublisher publisher({watched});
  publisher.publish(viewers_, start_);
  EXPECT_TRUE(stranger.written.empty());
  EXPECT_TRUE(other.written.empty());
  EXPECT_EQ(watcher.written.size(), 1U);
}

TEST_F(TopicPublisherTest, SlowViewerGetsTheLatestOnly) {
  int skipped = 0;
  Topic latest = topic();
  latest.delivery = Topic::Delivery::kLatest;
  latest.on_skipped = [&] { ++skipped; };
  FakeSocket& slow = add_viewer();
  TopicPublisher publisher({latest});
  for (int i = 0; i < 4; ++i) {
    ++revision_;
    text_ = std::to_string(i);
    publisher.publish(viewers_, start_ + i * 100ms);
  }
  slow.take_next();
  ASSERT_EQ(slow.written.size(), 2U);
  EXPECT_EQ(text_of(slow.written[0]), "0");
  EXPECT_EQ(text_of(slow.written[1]), "3");
  EXPECT_EQ(skipped, 2);
  EXPECT_EQ(viewers_[0]->skipped_snapshots, 2U);
}

TEST_F(TopicPublisherTest, OwnMessagesFollowTheRevisionThatEachViewerHas) {
  Topic::Revision last = 0;
  Topic own{.name = "own",
            .delivery = Topic::Delivery::kMust,
            .write_own = [&](const Audience&, auto seen, v1::ViewerUpdate& update) {
              if (seen == last) return last;
              update.mutable_welcome()->set_version(std::to_string(seen.value_or(0)));
              return last;
            }};
  FakeSocket& socket = add_viewer();
  TopicPublisher publisher({own});
  last = 3;
  publisher.publish(viewers_, start_);
  socket.take_next();
  publisher.publish(viewers_, start_ + 1ms);
  ASSERT_EQ(socket.written.size(), 1U) << "a message that stays empty is not sent";
  last = 5;
  publisher.publish(viewers_, start_ + 2ms);
  ASSERT_EQ(socket.written.size(), 2U);
  EXPECT_EQ(text_of(socket.written[1]), "3");
}

}  // namespace
}  // namespace aprsim::web
