#include "protocols/web/viewer/viewers.hpp"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace aprsim::web {
namespace {

/// Accepts one message, and never says that it is written.
class SlowSocket final : public WebSocket {
 public:
  void start(Events) override {}
  void write(WebMessage) override {}
  void close(const std::string& why, bool) override { closed = why; }
  void drop() override {}

  std::string closed;
};

class ViewersTest : public ::testing::Test {
 protected:
  std::shared_ptr<SlowSocket> add(std::size_t messages) {
    auto socket = std::make_shared<SlowSocket>();
    const auto viewer = std::make_shared<Viewer>(++id_, socket, "peer", Viewer::Events{});
    viewers_.add(viewer);
    viewer->start();
    const auto message = std::make_shared<const std::string>(kMessage, 'x');
    for (std::size_t i = 0; i < messages; ++i) viewer->send(message);
    // Only the latest message of a slot waits.
    for (int i = 0; i < 5; ++i) (void)viewer->send_latest(0, message);
    EXPECT_EQ(viewer->waiting_bytes(), (messages + 1) * kMessage);
    return socket;
  }

  static constexpr std::size_t kMessage = 1000;
  Viewers viewers_{20 * kMessage};
  std::uint64_t id_ = 0;
};

TEST_F(ViewersTest, StayWhileTheyKeepTheLimitTogether) {
  const auto first = add(9), second = add(9);
  viewers_.limit_waiting();
  EXPECT_EQ(first->closed, "");
  EXPECT_EQ(second->closed, "");
}

TEST_F(ViewersTest, TheSlowestAreClosedBeyondTheLimit) {
  const auto first = add(5), second = add(40), third = add(8), fourth = add(20);
  viewers_.limit_waiting();
  EXPECT_EQ(second->closed, "too slow");
  EXPECT_EQ(fourth->closed, "too slow");
  EXPECT_EQ(first->closed, "");
  EXPECT_EQ(third->closed, "");
}

}  // namespace
}  // namespace aprsim::web
