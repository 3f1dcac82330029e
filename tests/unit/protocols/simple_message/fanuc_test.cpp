#include <string>

#include "tests/unit/protocols/simple_message/server_fixture.hpp"

namespace aprsim::simple_message {
namespace {

using testing::eventually;
using testing::SimpleMessageClient;

class FanucPorts : public testing::ServerTest {
 protected:
  FanucPorts() : ServerTest(ControllerKind::kFanucKarel) { start(); }

  static Message point(std::int32_t sequence, const Joints& joints = {}) {
    return {MessageType::kTrajectoryPoint, Communication::kServiceRequest, ReplyCode::kNone,
            TrajectoryPoint{sequence, joints, 0.1F, 10}};
  }
  /// The reply's sequence number and code.
  static std::pair<std::int32_t, ReplyCode> reply_of(SimpleMessageClient& client) {
    const Message reply = client.receive();
    EXPECT_EQ(reply.type, MessageType::kJointPosition);
    EXPECT_EQ(reply.communication, Communication::kServiceReply);
    return {std::get<JointPosition>(reply.body).sequence, reply.reply};
  }
  /// The status of the latest snapshot: the second one that comes was made after it was published.
  RobotStatus status() {
    SimpleMessageClient client(ports_.state);
    int seen = 0;
    while (true) {
      const Message message = client.receive();
      if (message.type == MessageType::kRobotStatus && ++seen == 1) {
        return std::get<RobotStatus>(message.body);
      }
    }
  }
};

TEST_F(FanucPorts, APointIsAcknowledgedAtOnceAndHandedOver) {
  SimpleMessageClient client(ports_.motion);
  client.send(point(0, {0.1F, 0.2F, 0.3F, 0, -1.5F, 0}));
  EXPECT_EQ(reply_of(client), (std::pair{0, ReplyCode::kSuccess}));
  ASSERT_TRUE(cell_.cell().wait_for_commands(2));
  const auto claims = cell_.actions<api::ClaimMotion>();
  ASSERT_EQ(claims.size(), 1U);
  EXPECT_EQ(claims[0].mode, api::StreamMode::kMoves);
  EXPECT_NE(claims[0].commander.find("simple_message.fanuc of 127.0.0.1"), std::string::npos);
  const auto moves = cell_.actions<api::AppendMove>();
  ASSERT_EQ(moves.size(), 1U);
  EXPECT_EQ(moves[0].stream, 1U);
  EXPECT_DOUBLE_EQ(moves[0].speed, 0.2);
  EXPECT_DOUBLE_EQ(moves[0].rounding, 0.5);
  // The third joint is counted against the horizontal.
  EXPECT_NEAR(moves[0].position_rad.at(1), 0.2, 1e-6);
  EXPECT_NEAR(moves[0].position_rad.at(2), 0.5, 1e-6);
}

TEST_F(FanucPorts, OnePointMovesOneWaitsAndTheNextLiesUnread) {
  SimpleMessageClient client(ports_.motion);
  for (int i = 0; i < 4; ++i) client.send(point(i));
  EXPECT_EQ(reply_of(client).first, 0);
  EXPECT_EQ(reply_of(client).first, 1);
  EXPECT_FALSE(client.readable(kWhile));
  EXPECT_EQ(motion().points_left, 2U);
  change([](auto& robot) { --robot.motion.points_left; });
  EXPECT_EQ(reply_of(client).first, 2);
  EXPECT_FALSE(client.readable(kWhile));
  change([](auto& robot) { --robot.motion.points_left; });
  EXPECT_EQ(reply_of(client).first, 3);
}

TEST_F(FanucPorts, APointOutOfRangeIsReportedAndEndsTheConnection) {
  SimpleMessageClient client(ports_.motion);
  client.send(point(5, {3.1F}));
  EXPECT_EQ(reply_of(client), (std::pair{5, ReplyCode::kSuccess}));
  EXPECT_EQ(reply_of(client), (std::pair{5, ReplyCode::kFailure}));
  EXPECT_TRUE(client.ended());
  EXPECT_TRUE(cell_.actions<api::AppendMove>().empty());
}

TEST_F(FanucPorts, APointThatIsNoNumberIsOutOfRange) {
  SimpleMessageClient client(ports_.motion);
  client.send(point(6, {0, std::numeric_limits<float>::quiet_NaN()}));
  EXPECT_EQ(reply_of(client).second, ReplyCode::kSuccess);
  EXPECT_EQ(reply_of(client).second, ReplyCode::kFailure);
  EXPECT_TRUE(client.ended());
}

TEST_F(FanucPorts, SpecialSequenceNumbersGetNoReplyButTheStop) {
  SimpleMessageClient client(ports_.motion);
  client.send(point(0));
  EXPECT_EQ(reply_of(client).first, 0);
  for (const int sequence : {kStartDownload, kStartStreaming, kEndTrajectory, -77}) {
    client.send(point(sequence));
  }
  client.send(point(kStopTrajectory));
  EXPECT_EQ(reply_of(client), (std::pair{kStopTrajectory, ReplyCode::kSuccess}));
  EXPECT_EQ(cell_.actions<api::StopStream>().size(), 1U);
  EXPECT_EQ(cell_.actions<api::AppendMove>().size(), 1U);
}

TEST_F(FanucPorts, NeitherTypeNorLengthOfARequestMatters) {
  SimpleMessageClient client(ports_.motion);
  std::string bytes = encode(point(3), ByteOrder::kBig).substr(0, 60);
  bytes.replace(0, 8, encode_word(7, ByteOrder::kBig) + encode_word(4711, ByteOrder::kBig));
  client.send_bytes(bytes + bytes.substr(0, 13));
  EXPECT_EQ(reply_of(client), (std::pair{3, ReplyCode::kSuccess}));
  client.send_bytes(bytes.substr(13));
  EXPECT_EQ(reply_of(client), (std::pair{3, ReplyCode::kSuccess}));
}

TEST_F(FanucPorts, APointWaitsWhileAnotherCommanderHasTheRobot) {
  change([](auto& robot) { robot.motion.source = api::MotionSource::kCommands; });
  SimpleMessageClient client(ports_.motion);
  client.send(point(0));
  client.send(point(1));
  EXPECT_EQ(reply_of(client).first, 0);
  EXPECT_FALSE(client.readable(kWhile));
  EXPECT_TRUE(cell_.cell().commands().empty());
  change([](auto& robot) { robot.motion.source = api::MotionSource::kNone; });
  EXPECT_EQ(reply_of(client).first, 1);
  EXPECT_TRUE(eventually([&] { return cell_.actions<api::AppendMove>().size() == 2; }));
}

TEST_F(FanucPorts, WhatWasHandedOverIsFinishedWithoutItsClient) {
  {
    SimpleMessageClient client(ports_.motion);
    client.send(point(0));
    EXPECT_EQ(reply_of(client).first, 0);
  }
  ASSERT_TRUE(eventually([&] { return !cell_.actions<api::ReleaseMotion>().empty(); }));
  EXPECT_TRUE(cell_.actions<api::ReleaseMotion>().front().when_done);
  EXPECT_TRUE(cell_.actions<api::StopStream>().empty());
}

TEST_F(FanucPorts, ASecondClientIsServedAfterTheFirst) {
  auto first = std::make_unique<SimpleMessageClient>(ports_.motion);
  first->send(point(kStopTrajectory));
  EXPECT_EQ(reply_of(*first).first, kStopTrajectory);
  SimpleMessageClient second(ports_.motion);
  second.send(point(kStopTrajectory));
  EXPECT_FALSE(second.readable(kWhile));
  first.reset();
  EXPECT_EQ(reply_of(second).first, kStopTrajectory);
}

TEST_F(FanucPorts, AStatusFollowsEveryEleventhPosition) {
  change([](auto& robot) {
    robot.joints[1].position_rad = 0.25;
    robot.joints[2].position_rad = 1;
  });
  SimpleMessageClient client(ports_.state);
  while (client.receive().type != MessageType::kRobotStatus) {
  }
  for (int i = 0; i < 11; ++i) {
    const Message message = client.receive();
    ASSERT_EQ(message.type, MessageType::kJointPosition) << i;
    EXPECT_EQ(message.communication, Communication::kTopic);
    EXPECT_EQ(message.reply, ReplyCode::kNone);
    EXPECT_FLOAT_EQ(std::get<JointPosition>(message.body).position[1], 0.25F);
    EXPECT_FLOAT_EQ(std::get<JointPosition>(message.body).position[2], 0.75F);
  }
  EXPECT_EQ(client.receive().type, MessageType::kRobotStatus);
}

TEST_F(FanucPorts, StatusOfARobotAtRest) {
  const RobotStatus now = status();
  EXPECT_EQ(now.drives_powered, 1);
  EXPECT_EQ(now.e_stopped, 0);
  EXPECT_EQ(now.error_code, 0);
  EXPECT_EQ(now.in_error, 0);
  EXPECT_EQ(now.in_motion, 0);
  EXPECT_EQ(now.mode, kAutomaticMode);
  EXPECT_EQ(now.motion_possible, 1);
}

TEST_F(FanucPorts, StatusOfAMovingRobot) {
  change([](auto& robot) { robot.moving = true; });
  EXPECT_EQ(status().in_motion, 1);
}

TEST_F(FanucPorts, StatusAfterAProtectiveStop) {
  change([](auto& robot) { robot.protective_stop = true; });
  const RobotStatus now = status();
  EXPECT_EQ(now.in_error, 1);
  EXPECT_EQ(now.error_code, 11050);
  EXPECT_EQ(now.e_stopped, 0);
  EXPECT_EQ(now.motion_possible, 0);
}

TEST_F(FanucPorts, StatusWithDrivesOff) {
  change([](auto& robot) { robot.drives_on = false; });
  const RobotStatus now = status();
  EXPECT_EQ(now.drives_powered, 0);
  EXPECT_EQ(now.motion_possible, 0);
}

TEST_F(FanucPorts, StatusInAnEmergencyStop) {
  faults_.begin(faults::Kind::kCellEmergencyStop);
  const RobotStatus now = status();
  EXPECT_EQ(now.e_stopped, 1);
  EXPECT_EQ(now.drives_powered, 0);
  EXPECT_EQ(now.motion_possible, 0);
}

TEST_F(FanucPorts, StatusWithAFaultOfADrive) {
  faults_.begin(faults::Kind::kDriveFault, 1);
  EXPECT_EQ(status().in_error, 0) << "the other robot's";
  faults_.begin(faults::Kind::kDriveFault, 0);
  EXPECT_EQ(status().in_error, 1);
}

TEST_F(FanucPorts, GripperSpeaksInWords) {
  SimpleMessageClient client(ports_.gripper);
  const auto word = [&](std::int32_t command) {
    client.send_bytes(encode_word(command, ByteOrder::kBig));
    return client.take(4);
  };
  EXPECT_EQ(word(3), encode_word(0, ByteOrder::kBig));
  EXPECT_EQ(word(1).size(), 4U);
  EXPECT_EQ(word(3), encode_word(1, ByteOrder::kBig));
  EXPECT_EQ(word(0).size(), 4U);
  EXPECT_EQ(word(3), encode_word(0, ByteOrder::kBig));
  const auto settings = cell_.actions<api::SetGripper>();
  ASSERT_EQ(settings.size(), 2U);
  EXPECT_EQ(settings[0].setting, 0);
  EXPECT_EQ(settings[1].setting, 1);
  client.send_bytes(encode_word(99, ByteOrder::kBig));
  EXPECT_TRUE(client.ended());
}

TEST_F(FanucPorts, GripperShowsWhatOthersCommanded) {
  SimpleMessageClient client(ports_.gripper);
  change([](auto& robot) { robot.gripper.setting = 0; });
  client.send_bytes(encode_word(3, ByteOrder::kBig));
  EXPECT_EQ(client.take(4), encode_word(1, ByteOrder::kBig));
}

TEST_F(FanucPorts, GripperEndsAClientThatSendsAnotherWord) {
  SimpleMessageClient client(ports_.gripper);
  client.send_bytes(encode_word(42, ByteOrder::kBig));
  EXPECT_TRUE(client.ended());
  EXPECT_TRUE(cell_.cell().commands().empty());
}

}  // namespace
}  // namespace aprsim::simple_message
