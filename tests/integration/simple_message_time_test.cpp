// Virtual time on the daemon's Simple Message ports: requests of declared pacers are the clock.

#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/cell_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/simple_message_client.hpp"

namespace aprsim::test {
namespace {

using namespace simple_message;

constexpr std::uint64_t kPollSteps = 25;
/// A word of the Fanuc's gripper server that asks for its state.
constexpr std::int32_t kAskState = 3;

std::vector<std::string> in_virtual_time(const std::string& pacers) {
  return {"--time", "virtual", "--no-web", "--scene", "aprs_2024", "--pacers", pacers};
}

MotionReply command(SimpleMessageClient& client, MotionCommand command) {
  return client.ask<MotionReply>(MessageType::kMotionControl,
                                 MotionControl{0, 0, static_cast<std::int32_t>(command), {}});
}

void poll_gripper(SimpleMessageClient& gripper) {
  gripper.send_bytes(encode_word(kAskState, ByteOrder::kBig));
  (void)gripper.take(kLengthSize);
}

/// The joints of the latest state that has come.
class StateClient {
 public:
  explicit StateClient(std::uint16_t port) : client_(port) {}

  Joints latest() {
    while (!has_joints_ || client_.readable(std::chrono::milliseconds(0))) {
      const Message message = client_.receive();
      ++messages_;
      if (const auto* position = std::get_if<JointPosition>(&message.body)) {
        joints_ = position->position;
      } else if (const auto* feedback = std::get_if<JointFeedback>(&message.body)) {
        joints_ = feedback->position;
      } else {
        continue;
      }
      has_joints_ = true;
    }
    return joints_;
  }
  [[nodiscard]] bool has_come() { return client_.readable(std::chrono::milliseconds(0)); }
  [[nodiscard]] int messages() const { return messages_; }

 private:
  SimpleMessageClient client_;
  Joints joints_{};
  bool has_joints_ = false;
  int messages_ = 0;
};

TEST(SimpleMessageTime, ARequestTakesItsPeriodHoweverFastItComes) {
  DaemonProcess daemon(in_virtual_time("motion.motoman"));
  CellClient cell(daemon.port("grpc"));
  EXPECT_EQ(cell.snapshot().virtual_time().awaited(0), "motion.motoman");
  SimpleMessageClient motion(daemon.port("motion.motoman"));
  for (std::uint64_t poll = 1; poll <= 40; ++poll) {
    (void)command(motion, MotionCommand::kCheckMotionReady);
    ASSERT_EQ(cell.snapshot().step(), poll * kPollSteps);
  }
  EXPECT_TRUE(cell.snapshot().virtual_time().reproducible());
}

TEST(SimpleMessageTime, GripperRequestsPaceToo) {
  DaemonProcess daemon(in_virtual_time("gripper.fanuc"));
  CellClient cell(daemon.port("grpc"));
  SimpleMessageClient gripper(daemon.port("gripper.fanuc"));
  for (std::uint64_t poll = 1; poll <= 10; ++poll) {
    poll_gripper(gripper);
    ASSERT_EQ(cell.snapshot().step(), poll * kPollSteps);
  }
}

TEST(SimpleMessageTime, EveryStateOfThePeriodComesBeforeTheReply) {
  DaemonProcess daemon(in_virtual_time("motion.motoman,state.motoman"));
  SimpleMessageClient motion(daemon.port("motion.motoman"));
  StateClient state(daemon.port("state.motoman"));
  // Time waits for a reader that does not read.
  for (int poll = 0; poll < 40; ++poll) {
    (void)command(motion, MotionCommand::kCheckMotionReady);
    if (state.has_come()) (void)state.latest();
  }
  // Feedback and status each 25 ms; the last one is sent beside the last reply.
  EXPECT_GE(state.messages(), 2 * 39);
}

TEST(SimpleMessageTime, APointThatWaitsPassesTime) {
  DaemonProcess daemon(in_virtual_time("motion.fanuc"));
  CellClient cell(daemon.port("grpc"));
  SimpleMessageClient motion(daemon.port("motion.fanuc"));
  for (int i = 0; i < 4; ++i) {
    Joints to{};
    to[4] = -1.5708F + 0.2F * static_cast<float>(i % 2);
    (void)motion.ask<JointPosition>(MessageType::kTrajectoryPoint,
                                    TrajectoryPoint{i, to, 0.1F, 10});
  }
  // The third and fourth are taken once a motion before them has ended.
  EXPECT_GT(cell.snapshot().step(), 4 * kPollSteps);
  EXPECT_TRUE(cell.snapshot().virtual_time().reproducible());
}

TEST(SimpleMessageTime, APausedCellAnswersWithoutTime) {
  DaemonProcess daemon(in_virtual_time("motion.motoman"));
  CellClient cell(daemon.port("grpc"));
  SimpleMessageClient motion(daemon.port("motion.motoman"));
  (void)command(motion, MotionCommand::kCheckMotionReady);
  grpc::ClientContext context;
  v1::PauseResponse response;
  CellClient::require(cell.control->Pause(&context, {}, &response));
  (void)command(motion, MotionCommand::kCheckMotionReady);
  EXPECT_EQ(cell.snapshot().step(), kPollSteps);
}

}  // namespace
}  // namespace aprsim::test
