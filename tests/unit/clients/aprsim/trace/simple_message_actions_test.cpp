// Actions of clients on Simple Message ports, as `aprsim trace` lists and compares them.

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "clients/aprsim/trace/action.hpp"
#include "protocols/simple_message/codec/message_codec.hpp"

namespace aprsim::trace {
namespace {

using namespace simple_message;

/// A run of one port.
class Port {
 public:
  void request(Body body, MessageType type) {
    add(true, encode({type, Communication::kServiceRequest, ReplyCode::kNone, std::move(body)},
                     ByteOrder::kBig));
  }
  void reply(Body body, MessageType type, ReplyCode code = ReplyCode::kSuccess) {
    add(false,
        encode({type, Communication::kServiceReply, code, std::move(body)}, ByteOrder::kBig));
  }
  void point(std::int32_t sequence, float time_s, float first_rad, MotionResult result) {
    TrajectoryPointFull point{0, sequence, 7, time_s, {}, {}, {}};
    point.position[0] = first_rad;
    request(point, MessageType::kTrajectoryPointFull);
    reply(MotionReply{0, sequence, 14, static_cast<std::int32_t>(result), 0, {}},
          MessageType::kMotionReply);
  }
  void word(bool from_client, std::int32_t value) {
    add(from_client, encode_word(value, ByteOrder::kBig));
  }
  [[nodiscard]] WireActions actions() const {
    Records records;
    for (const WireRecord& record : records_) records.push_back(&record);
    return simple_message_actions(records);
  }

 private:
  void add(bool from_client, std::string bytes) {
    WireRecord record;
    record.time_s = time_s_ += 0.1;
    record.wire.set_kind(v1::WIRE_KIND_SIMPLE_MESSAGE);
    record.wire.set_connection(1);
    record.wire.set_content(from_client ? v1::WIRE_CONTENT_RECEIVED : v1::WIRE_CONTENT_SENT);
    record.wire.set_data(std::move(bytes));
    records_.push_back(std::move(record));
  }

  std::vector<WireRecord> records_;
  double time_s_ = 0;
};

double number(const Action& action, const std::string& name) {
  for (const Field& field : action.fields) {
    if (field.name == name) return std::get<Number>(field.value).value;
  }
  ADD_FAILURE() << action.kind << " has no " << name;
  return 0;
}

TEST(SimpleMessageActions, PointsOfATrajectoryAreOneAction) {
  Port port;
  port.point(0, 0, 0, MotionResult::kSuccess);
  port.point(1, 0.5F, 0.1F, MotionResult::kSuccess);
  port.point(2, 1, 0.2F, MotionResult::kBusy);
  port.point(2, 1, 0.2F, MotionResult::kSuccess);
  port.point(0, 0, 0.2F, MotionResult::kSuccess);
  const WireActions found = port.actions();
  ASSERT_EQ(found.actions.size(), 2U);
  const Action& first = found.actions[0];
  EXPECT_EQ(first.kind, "trajectory");
  EXPECT_EQ(first.outcome, "done");
  EXPECT_EQ(number(first, "points"), 3);
  EXPECT_FLOAT_EQ(static_cast<float>(number(first, "time")), 1);
  EXPECT_FLOAT_EQ(static_cast<float>(number(first, "joint 1")), 0.2F);
  EXPECT_NEAR(first.duration_s.value(), 0.7, 1e-9);
}

TEST(SimpleMessageActions, CommandsHaveTheirNamesAndResults) {
  Port port;
  const auto ask = [&](MotionCommand command, MotionResult result, Subcode subcode) {
    const auto number = static_cast<std::int32_t>(command);
    port.request(MotionControl{0, 0, number, {}}, MessageType::kMotionControl);
    port.reply(MotionReply{0,
                           0,
                           number,
                           static_cast<std::int32_t>(result),
                           static_cast<std::int32_t>(subcode),
                           {}},
               MessageType::kMotionReply);
  };
  ask(MotionCommand::kStartTrajectoryMode, MotionResult::kNotReady, Subcode::kEmergencyStop);
  ask(MotionCommand::kCheckQueueCount, MotionResult::kSuccess, Subcode::kNone);
  port.request(WriteIo{10010, 1}, MessageType::kWriteIoBit);
  port.reply(WriteIoReply{0}, MessageType::kWriteIoBitReply);
  const WireActions found = port.actions();
  ASSERT_EQ(found.actions.size(), 2U);
  EXPECT_EQ(found.actions[0].kind, "START_TRAJ_MODE");
  EXPECT_EQ(found.actions[0].outcome, "not ready 5003");
  EXPECT_EQ(found.actions[1].kind, "write signal 10010");
  EXPECT_EQ(number(found.actions[1], "value"), 1);
  EXPECT_EQ(found.actions[1].outcome, "done");
  EXPECT_EQ(found.polls, 1U);
  EXPECT_EQ(found.reads.at("CHECK_QUEUE_CNT"), 1U);
}

TEST(SimpleMessageActions, FanucPointOutOfRangeFails) {
  Port port;
  port.request(TrajectoryPoint{0, {9}, 0.1F, 10}, MessageType::kTrajectoryPoint);
  port.reply(JointPosition{}, MessageType::kJointPosition);
  port.reply(JointPosition{}, MessageType::kJointPosition, ReplyCode::kFailure);
  const WireActions found = port.actions();
  ASSERT_EQ(found.actions.size(), 1U);
  EXPECT_EQ(found.actions[0].outcome, "failure");
}

TEST(SimpleMessageActions, WordsOfTheGripperServer) {
  Port port;
  for (const std::int32_t word : {3, 1, 0}) {
    port.word(true, word);
    port.word(false, 0);
  }
  port.word(true, 99);
  const WireActions found = port.actions();
  ASSERT_EQ(found.actions.size(), 3U);
  EXPECT_EQ(found.actions[0].kind, "close gripper");
  EXPECT_EQ(found.actions[1].kind, "open gripper");
  EXPECT_EQ(found.actions[1].outcome, "done");
  EXPECT_EQ(found.actions[2].kind, "end");
  EXPECT_EQ(found.polls, 1U);
}

TEST(SimpleMessageActions, StatesAreNoActions) {
  Port port;
  port.reply(JointFeedback{}, MessageType::kJointFeedback);
  port.reply(RobotStatus{}, MessageType::kRobotStatus);
  EXPECT_TRUE(port.actions().actions.empty());
  EXPECT_EQ(port.actions().polls, 2U);
}

}  // namespace
}  // namespace aprsim::trace
