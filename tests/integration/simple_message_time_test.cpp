// Virtual time on the daemon's Simple Message ports: requests of declared pacers are the clock.

#include <array>
#include <cstdint>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <string>
#include <utility>
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

// ---- the same clients, the same bits

constexpr std::uint64_t kEnd = 5000;

/// The Motoman's client: START_TRAJ_MODE, then the first joint to and fro by points, BUSY ones
/// again, then questions for the queue. Each request is the clock.
class MotomanClient {
 public:
  explicit MotomanClient(const DaemonProcess& daemon)
      : state_(daemon.port("state.motoman")), motion_(daemon.port("motion.motoman")) {}

  void send_next() {
    if (!from_ && started_ && state_.has_come()) from_ = state_.latest();
    if (!started_ || !from_ || waits_ || done()) {
      return send_command(started_ ? MotionCommand::kCheckQueueCount
                                   : MotionCommand::kStartTrajectoryMode);
    }
    const float share = static_cast<float>(point_) / kPoints;
    TrajectoryPointFull point{0, point_, 7, 0.1F * static_cast<float>(point_), *from_, {}, {}};
    point.position[0] += share * share * (3 - 2 * share) * kSwings.at(swing_);
    point.velocity[0] = 6 * share * (1 - share) * kSwings.at(swing_);
    motion_.send({MessageType::kTrajectoryPointFull, Communication::kServiceRequest,
                  ReplyCode::kNone, point});
    sends_point_ = true;
  }
  [[nodiscard]] bool answered() { return motion_.readable(std::chrono::milliseconds(1)); }
  void take_answer() {
    const auto reply = motion_.receive_body<MotionReply>();
    ASSERT_LE(reply.result, 1) << reply.subcode;
    started_ = true;
    if (!std::exchange(sends_point_, false)) {
      // The next swing begins where the queue has run out.
      waits_ = waits_ && reply.subcode != 0;
      return;
    }
    busy_ += reply.result;
    if (reply.result == 0 && ++point_ > kPoints) {
      (*from_)[0] += kSwings.at(swing_++);
      point_ = 0;
      waits_ = true;
    }
  }
  [[nodiscard]] int busy() const { return busy_; }
  [[nodiscard]] bool done() const { return swing_ == kSwings.size(); }

 private:
  static constexpr int kPoints = 12;
  static constexpr std::array<float, 2> kSwings{0.2F, -0.3F};

  void send_command(MotionCommand command) {
    motion_.send({MessageType::kMotionControl, Communication::kServiceRequest, ReplyCode::kNone,
                  MotionControl{0, 0, static_cast<std::int32_t>(command), {}}});
  }

  StateClient state_;
  SimpleMessageClient motion_;
  std::optional<Joints> from_;
  bool started_ = false, sends_point_ = false, waits_ = false;
  std::size_t swing_ = 0;
  int point_ = 0, busy_ = 0;
};

/// The Fanuc's client: its gripper's port is the clock, points go beside it.
class FanucClient {
 public:
  explicit FanucClient(const DaemonProcess& daemon)
      : state_(daemon.port("state.fanuc")),
        motion_(daemon.port("motion.fanuc")),
        gripper_(daemon.port("gripper.fanuc")) {}

  void send_next() {
    if (!from_ && state_.has_come()) from_ = state_.latest();
    if (from_ && sent_ < kPoints && sent_ == acknowledged_) {
      Joints to = *from_;
      to[0] += 0.1F * static_cast<float>(sent_ % 3);
      motion_.send({MessageType::kTrajectoryPoint, Communication::kServiceRequest, ReplyCode::kNone,
                    TrajectoryPoint{sent_++, to, 0.1F, 10}});
    }
    gripper_.send_bytes(encode_word(kAskState, ByteOrder::kBig));
  }
  [[nodiscard]] bool answered() { return gripper_.readable(std::chrono::milliseconds(1)); }
  void take_answer() {
    (void)gripper_.take(kLengthSize);
    if (acknowledged_ < sent_ && motion_.readable(std::chrono::milliseconds(0))) {
      (void)motion_.receive();
      ++acknowledged_;
    }
  }
  [[nodiscard]] bool done() const { return acknowledged_ == kPoints; }

 private:
  static constexpr int kPoints = 8;

  StateClient state_;
  SimpleMessageClient motion_, gripper_;
  std::optional<Joints> from_;
  int sent_ = 0, acknowledged_ = 0;
};

struct Outcome {
  std::uint64_t step = 0, hash = 0;
  int busy = 0;
  bool operator==(const Outcome&) const = default;
};

std::ostream& operator<<(std::ostream& out, const Outcome& outcome) {
  return out << "step " << outcome.step << ", hash " << outcome.hash << ", " << outcome.busy
             << " busy";
}

/// Both clients until the end. The slower they are, the more looks at the cell each request takes.
Outcome run_clients(int looks) {
  DaemonProcess daemon(in_virtual_time("motion.motoman,gripper.fanuc"));
  CellClient cell(daemon.port("grpc"));
  MotomanClient motoman(daemon);
  FanucClient fanuc(daemon);
  fanuc.send_next();
  motoman.send_next();
  const auto serve = [&](auto& client) {
    if (!client.answered()) return false;
    client.take_answer();
    for (int i = 0; i < looks; ++i) (void)cell.snapshot();
    if (cell.snapshot().step() >= kEnd) return true;
    client.send_next();
    return false;
  };
  const auto deadline = TcpSocket::Clock::now() + std::chrono::minutes(2);
  while (!serve(fanuc) && !serve(motoman)) {
    if (TcpSocket::Clock::now() > deadline) throw std::runtime_error("no end: " + daemon.log());
  }
  EXPECT_TRUE(motoman.done() && fanuc.done());
  const auto end = cell.snapshot();
  EXPECT_TRUE(end.virtual_time().reproducible());
  return {end.step(), end.state_hash(), motoman.busy()};
}

TEST(SimpleMessageTime, TheSameClientsGiveTheSameBitsHoweverFastTheyAre) {
  const Outcome first = run_clients(0);
  EXPECT_GT(first.busy, 0);
  for (const int looks : {0, 5}) EXPECT_EQ(run_clients(looks), first) << looks;
}

}  // namespace
}  // namespace aprsim::test
