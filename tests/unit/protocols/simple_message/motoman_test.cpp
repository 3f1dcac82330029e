#include <cmath>
#include <numbers>
#include <string>

#include "tests/unit/protocols/simple_message/server_fixture.hpp"

namespace aprsim::simple_message {
namespace {

using testing::eventually;
using testing::SimpleMessageClient;

struct Outcome {
  std::int32_t result = 0, subcode = 0;
  bool operator==(const Outcome&) const = default;
};

std::ostream& operator<<(std::ostream& out, const Outcome& outcome) {
  return out << outcome.result << " / " << outcome.subcode;
}

class MotomanPorts : public testing::ServerTest {
 protected:
  MotomanPorts() : ServerTest(ControllerKind::kMotomanFs100) { start(); }

  static Outcome outcome_of(const MotionReply& reply) { return {reply.result, reply.subcode}; }
  static Outcome control(SimpleMessageClient& client, MotionCommand command) {
    const auto number = static_cast<std::int32_t>(command);
    const auto reply =
        client.ask<MotionReply>(MessageType::kMotionControl, MotionControl{0, 3, number, {}});
    EXPECT_EQ(reply.sequence, 3);
    EXPECT_EQ(reply.command, number);
    return outcome_of(reply);
  }
  static TrajectoryPointFull point(std::int32_t sequence, float time, const Joints& position = {},
                                   const Joints& velocity = {}) {
    return {0, sequence, 7, time, position, velocity, {}};
  }
  static Outcome send(SimpleMessageClient& client, const TrajectoryPointFull& point) {
    const auto reply = client.ask<MotionReply>(MessageType::kTrajectoryPointFull, point);
    EXPECT_EQ(reply.sequence, point.sequence);
    EXPECT_EQ(reply.command, 14);
    return outcome_of(reply);
  }
  static Outcome start_mode(SimpleMessageClient& client) {
    return control(client, MotionCommand::kStartTrajectoryMode);
  }
  RobotStatus status() {
    SimpleMessageClient client(ports_.state);
    while (true) {
      const Message message = client.receive();
      if (message.type == MessageType::kRobotStatus) return std::get<RobotStatus>(message.body);
    }
  }
  static std::int32_t write(SimpleMessageClient& client, std::int32_t address, std::int32_t value) {
    return client.ask<WriteIoReply>(MessageType::kWriteIoBit, WriteIo{address, value}).result;
  }
  static std::int32_t read(SimpleMessageClient& client, std::int32_t address) {
    return client.ask<ReadIoReply>(MessageType::kReadIoBit, ReadIo{address}).value;
  }
};

// ---- START_TRAJ_MODE

TEST_F(MotomanPorts, TrajectoryModeClaimsTheRobot) {
  SimpleMessageClient client(ports_.motion);
  EXPECT_EQ(control(client, MotionCommand::kCheckMotionReady), (Outcome{2, 5008}));
  EXPECT_EQ(start_mode(client), (Outcome{0, 0}));
  const auto claims = cell_.actions<api::ClaimMotion>();
  ASSERT_EQ(claims.size(), 1U);
  EXPECT_EQ(claims[0].mode, api::StreamMode::kTimed);
  EXPECT_TRUE(claims[0].reset);
  EXPECT_EQ(control(client, MotionCommand::kCheckMotionReady), (Outcome{0, 0}));
  EXPECT_EQ(status().motion_possible, 1);
  // Ready already.
  EXPECT_EQ(start_mode(client), (Outcome{0, 0}));
  EXPECT_EQ(cell_.actions<api::ClaimMotion>().size(), 1U);
}

TEST_F(MotomanPorts, TrajectoryModeIsRefusedWhileAnotherJobMovesTheRobot) {
  change([](auto& robot) { robot.motion.source = api::MotionSource::kCommands; });
  SimpleMessageClient client(ports_.motion);
  EXPECT_EQ(start_mode(client), (Outcome{5, 5009}));
  EXPECT_TRUE(cell_.cell().commands().empty());
}

TEST_F(MotomanPorts, TrajectoryModeIsRefusedInAnEmergencyStop) {
  faults_.begin(faults::Kind::kRobotEmergencyStop, 1);
  SimpleMessageClient client(ports_.motion);
  EXPECT_EQ(start_mode(client), (Outcome{5, 5003}));
}

TEST_F(MotomanPorts, TrajectoryModeClearsAnAlarmAndSwitchesTheDrivesOn) {
  change([](auto& robot) {
    robot.motion.alarm = "joint_b beyond its limit";
    robot.drives_on = false;
  });
  SimpleMessageClient client(ports_.motion);
  EXPECT_EQ(control(client, MotionCommand::kCheckMotionReady), (Outcome{2, 5001}));
  EXPECT_EQ(start_mode(client), (Outcome{0, 0}));
}

TEST_F(MotomanPorts, TrajectoryModeGivesUpOnACellThatDoesNotAnswer) {
  server_->stop();
  options_.claim_timeout = std::chrono::milliseconds(50);
  start();
  cell_.hold();
  SimpleMessageClient client(ports_.motion);
  EXPECT_EQ(start_mode(client).result, 5);
}

// ---- points

TEST_F(MotomanPorts, TheFirstPointMayBeThirtyPulsesOff) {
  constexpr double kPulse = 3.14159265358979 / 180 / 1024;
  change([](auto& robot) { robot.motion.reference_rad[0] = 0; });
  SimpleMessageClient client(ports_.motion);
  start_mode(client);
  EXPECT_EQ(send(client, point(0, 0, {static_cast<float>(30.5 * kPulse)})), (Outcome{0, 0}));
  EXPECT_EQ(send(client, point(0, 0, {static_cast<float>(-30.5 * kPulse)})), (Outcome{0, 0}));
  EXPECT_EQ(send(client, point(0, 0, {static_cast<float>(31.5 * kPulse)})), (Outcome{3, 3011}));
  EXPECT_EQ(send(client, point(0, 0, {0, 0, 0, 0, 0, 0, 1e30F})), (Outcome{3, 3011}));
  EXPECT_TRUE(cell_.actions<api::AppendPoints>().empty());
}

TEST_F(MotomanPorts, PointsAreHandedOverWithTimesSinceTheFirst) {
  SimpleMessageClient client(ports_.motion);
  start_mode(client);
  EXPECT_EQ(send(client, point(0, 1)), (Outcome{0, 0}));
  // As the laboratory's client repeats its start.
  EXPECT_EQ(send(client, point(1, 1)), (Outcome{0, 0}));
  EXPECT_EQ(send(client, point(2, 1.1F, {0.01F}, {0.2F})), (Outcome{0, 0}));
  EXPECT_EQ(send(client, point(3, 1.2009F, {0.02F})), (Outcome{0, 0}));
  EXPECT_EQ(send(client, point(4, 1.15F, {0.02F})), (Outcome{0, 0}));
  const auto appended = cell_.actions<api::AppendPoints>();
  ASSERT_EQ(appended.size(), 2U);
  EXPECT_TRUE(appended[0].begins);
  EXPECT_EQ(appended[0].points.at(0).time, std::chrono::milliseconds(100));
  // The controller keeps whole pulses.
  constexpr double kPulse_rad = std::numbers::pi / 180 / 1024;
  const double pulses = appended[0].points[0].position_rad.at(0) / kPulse_rad;
  EXPECT_NEAR(pulses, std::round(pulses), 1e-6);
  EXPECT_NEAR(appended[0].points[0].position_rad.at(0), 0.01, kPulse_rad);
  EXPECT_NEAR(appended[0].points[0].velocity_rad_s.at(0), 0.2, 1e-7);
  EXPECT_TRUE(appended[0].points[0].acceleration_rad_s2.empty());
  EXPECT_FALSE(appended[1].begins);
  EXPECT_EQ(appended[1].points.at(0).time, std::chrono::milliseconds(200));
}

TEST_F(MotomanPorts, BusyUntilThePointIsInTheQueue) {
  SimpleMessageClient client(ports_.motion);
  start_mode(client);
  send(client, point(0, 0));
  EXPECT_EQ(send(client, point(1, 0.8F)), (Outcome{0, 0}));
  EXPECT_EQ(control(client, MotionCommand::kCheckQueueCount), (Outcome{0, 200}));
  EXPECT_EQ(send(client, point(2, 0.9F)), (Outcome{0, 0}));
  EXPECT_EQ(send(client, point(3, 1.0F)), (Outcome{1, 0}));
  change([](auto& robot) { robot.motion.time = std::chrono::milliseconds(99); });
  EXPECT_EQ(send(client, point(3, 1.0F)), (Outcome{1, 0}));
  change([](auto& robot) { robot.motion.time = std::chrono::milliseconds(100); });
  EXPECT_EQ(send(client, point(3, 1.0F)), (Outcome{0, 0}));
  change([](auto& robot) { robot.motion.time = std::chrono::milliseconds(989); });
  EXPECT_EQ(control(client, MotionCommand::kCheckQueueCount), (Outcome{0, 3}));
  EXPECT_EQ(cell_.actions<api::AppendPoints>().size(), 3U);
}

TEST_F(MotomanPorts, PointsAreCheckedAsMotoRosDoes) {
  SimpleMessageClient client(ports_.motion);
  EXPECT_EQ(send(client, point(0, 0)), (Outcome{5, 5008}));
  start_mode(client);
  auto wrong = point(0, 0);
  wrong.group = 1;
  EXPECT_EQ(send(client, wrong), (Outcome{3, 3004}));
  wrong = point(0, 0);
  for (const int valid : {0, 3, 5, 6, 8}) {
    wrong.valid = valid;
    EXPECT_EQ(send(client, wrong), (Outcome{3, 3015})) << valid;
  }
  EXPECT_EQ(send(client, point(0, 14400)), (Outcome{3, 3016}));
  EXPECT_EQ(send(client, point(-1, 0)), (Outcome{3, 3005}));
  // Speeds are compared in whole rad/s: 2.27 allows up to below 3.
  EXPECT_EQ(send(client, point(0, 0, {}, {2.99F})), (Outcome{0, 0}));
  EXPECT_EQ(send(client, point(0, 0, {}, {3.0F})), (Outcome{3, 3013}));
  EXPECT_EQ(send(client, point(1, 0.1F, {}, {0, 0, 0, 0, 0, 0, -7})), (Outcome{3, 3013}));
  EXPECT_EQ(send(client, point(1, 0.1F, {}, {1e30F})), (Outcome{3, 3013}));
}

TEST_F(MotomanPorts, ANumberThatIsNoneIsInvalidData) {
  SimpleMessageClient client(ports_.motion);
  start_mode(client);
  const auto reply = client.ask<MotionReply>(MessageType::kTrajectoryPointFull,
                                             point(1, std::numeric_limits<float>::infinity()));
  EXPECT_EQ(outcome_of(reply), (Outcome{3, 3010}));
  EXPECT_TRUE(cell_.actions<api::AppendPoints>().empty());
}

TEST_F(MotomanPorts, APointForGroupsIsOneForTheFirst) {
  SimpleMessageClient client(ports_.motion);
  start_mode(client);
  TrajectoryPointsExtended points{1, 0, {}};
  points.points[0] = {0, 7, 0, {}, {}, {}};
  auto reply = client.ask<MotionReply>(MessageType::kTrajectoryPointsExtended, points);
  EXPECT_EQ(reply.command, 2016);
  EXPECT_EQ(outcome_of(reply), (Outcome{0, 0}));
  points.sequence = 1;
  points.points[0].time = 0.1F;
  client.ask<MotionReply>(MessageType::kTrajectoryPointsExtended, points);
  EXPECT_EQ(cell_.actions<api::AppendPoints>().size(), 1U);
  points.groups = 2;
  reply = client.ask<MotionReply>(MessageType::kTrajectoryPointsExtended, points);
  EXPECT_EQ(outcome_of(reply), (Outcome{3, 3004}));
}

TEST_F(MotomanPorts, AnAlarmInMidMotionClearsTheQueue) {
  SimpleMessageClient client(ports_.motion);
  start_mode(client);
  send(client, point(0, 0));
  send(client, point(1, 0.5F, {0.1F}));
  change([](auto& robot) {
    robot.motion = {};
    robot.motion.alarm = "joint_1 is too fast";
  });
  EXPECT_EQ(send(client, point(2, 0.6F, {0.1F})), (Outcome{5, 5001}));
  EXPECT_EQ(control(client, MotionCommand::kCheckQueueCount), (Outcome{0, 0}));
  EXPECT_EQ(status().in_error, 1);
}

TEST_F(MotomanPorts, ATrajectoryBehindAStopWaitsForTheRobotToStand) {
  SimpleMessageClient client(ports_.motion);
  start_mode(client);
  send(client, point(0, 0));
  send(client, point(1, 0.5F, {0.1F}));
  EXPECT_EQ(control(client, MotionCommand::kStopMotion), (Outcome{0, 0}));
  EXPECT_EQ(cell_.actions<api::StopStream>().size(), 1U);
  change([](auto& robot) { robot.motion.phase = api::StreamPhase::kStopping; });
  EXPECT_EQ(send(client, point(0, 0)), (Outcome{0, 0}));
  EXPECT_EQ(send(client, point(1, 0.1F)), (Outcome{0, 0}));
  EXPECT_EQ(send(client, point(2, 0.2F)), (Outcome{1, 0}));
  EXPECT_EQ(cell_.actions<api::AppendPoints>().size(), 1U);
  change([](auto& robot) { robot.motion.phase = api::StreamPhase::kReady; });
  EXPECT_TRUE(eventually([&] { return cell_.actions<api::AppendPoints>().size() == 2; }));
  EXPECT_TRUE(cell_.actions<api::AppendPoints>().back().begins);
}

TEST_F(MotomanPorts, APointBehindADryTrajectoryWaitsForTheRobotToStand) {
  SimpleMessageClient client(ports_.motion);
  start_mode(client);
  send(client, point(0, 0));
  send(client, point(1, 0.1F, {0.01F}, {0.2F}));
  change([](auto& robot) {
    robot.motion.time = std::chrono::milliseconds(100);
    robot.motion.phase = api::StreamPhase::kStopping;
  });
  EXPECT_EQ(send(client, point(2, 0.2F, {0.02F})), (Outcome{0, 0}));
  EXPECT_EQ(send(client, point(3, 0.3F, {0.03F})), (Outcome{1, 0}));
  EXPECT_EQ(cell_.actions<api::AppendPoints>().size(), 1U);
  change([](auto& robot) { robot.motion.phase = api::StreamPhase::kReady; });
  ASSERT_TRUE(eventually([&] { return cell_.actions<api::AppendPoints>().size() == 2; }));
  EXPECT_FALSE(cell_.actions<api::AppendPoints>().back().begins);
}

// ---- ends

TEST_F(MotomanPorts, TrajectoryModeEndsOnlyWithAnEmptyQueue) {
  SimpleMessageClient client(ports_.motion);
  start_mode(client);
  send(client, point(0, 0));
  send(client, point(1, 0.5F));
  EXPECT_EQ(control(client, MotionCommand::kStopTrajectoryMode), (Outcome{2, 0}));
  EXPECT_EQ(control(client, MotionCommand::kDisconnect), (Outcome{2, 0}));
  change([](auto& robot) { robot.motion.time = std::chrono::milliseconds(500); });
  EXPECT_EQ(control(client, MotionCommand::kStopTrajectoryMode), (Outcome{0, 0}));
  EXPECT_EQ(cell_.actions<api::ReleaseMotion>().size(), 1U);
  EXPECT_EQ(status().motion_possible, 0);
}

TEST_F(MotomanPorts, DisconnectEndsWithoutAReply) {
  SimpleMessageClient client(ports_.motion);
  start_mode(client);
  client.send({MessageType::kMotionControl, Communication::kServiceRequest, ReplyCode::kNone,
               MotionControl{0, 0, 200130, {}}});
  EXPECT_TRUE(client.ended());
  EXPECT_EQ(cell_.actions<api::ReleaseMotion>().size(), 1U);
}

TEST_F(MotomanPorts, TheQueueOfALostClientGoesOnWithTheNext) {
  {
    SimpleMessageClient client(ports_.motion);
    start_mode(client);
    send(client, point(0, 0));
    send(client, point(1, 0.5F));
  }
  ASSERT_TRUE(eventually([&] { return cell_.actions<api::PauseStream>().size() == 1; }));
  EXPECT_TRUE(cell_.actions<api::PauseStream>().front().paused);
  EXPECT_FALSE(cell_.actions<api::PauseStream>().front().ends_at);
  SimpleMessageClient next(ports_.motion);
  ASSERT_TRUE(eventually([&] { return cell_.actions<api::PauseStream>().size() == 2; }));
  EXPECT_FALSE(cell_.actions<api::PauseStream>().back().paused);
  // Ready still: the queue is not cleared.
  EXPECT_EQ(start_mode(next), (Outcome{0, 0}));
  EXPECT_EQ(control(next, MotionCommand::kCheckQueueCount), (Outcome{0, 125}));
}

TEST_F(MotomanPorts, WhatALostClientHasNotInTheQueueIsLost) {
  {
    SimpleMessageClient client(ports_.motion);
    start_mode(client);
    send(client, point(0, 0));
    send(client, point(1, 0.5F));
    EXPECT_EQ(send(client, point(2, 2.5F)), (Outcome{0, 0}));
    change([](auto& robot) { robot.motion.time = std::chrono::milliseconds(300); });
  }
  ASSERT_TRUE(eventually([&] { return cell_.actions<api::PauseStream>().size() == 1; }));
  // 200 increments of 4 ms.
  EXPECT_EQ(cell_.actions<api::PauseStream>().front().ends_at, std::chrono::milliseconds(1100));
  SimpleMessageClient next(ports_.motion);
  EXPECT_EQ(control(next, MotionCommand::kCheckQueueCount), (Outcome{0, 200}));
  change([](auto& robot) { robot.motion.time = std::chrono::milliseconds(1000); });
  EXPECT_EQ(control(next, MotionCommand::kCheckQueueCount), (Outcome{0, 25}));
}

TEST_F(MotomanPorts, APointBetweenTwoTicksEndsAnIncrement) {
  SimpleMessageClient client(ports_.motion);
  start_mode(client);
  send(client, point(0, 0));
  send(client, point(1, 0.301F));
  EXPECT_EQ(control(client, MotionCommand::kCheckQueueCount), (Outcome{0, 76}));
  send(client, point(2, 0.402F));
  EXPECT_EQ(control(client, MotionCommand::kCheckQueueCount), (Outcome{0, 102}));
  change([](auto& robot) { robot.motion.time = std::chrono::milliseconds(300); });
  EXPECT_EQ(control(client, MotionCommand::kCheckQueueCount), (Outcome{0, 27}));
  change([](auto& robot) { robot.motion.time = std::chrono::milliseconds(301); });
  EXPECT_EQ(control(client, MotionCommand::kCheckQueueCount), (Outcome{0, 26}));
}

TEST_F(MotomanPorts, PointsBetweenTicksFillTheQueue) {
  {
    SimpleMessageClient client(ports_.motion);
    start_mode(client);
    send(client, point(0, 0));
    for (int i = 1; i <= 10; ++i) send(client, point(i, 0.05F * static_cast<float>(i) + 0.001F));
    EXPECT_EQ(send(client, point(11, 2)), (Outcome{0, 0}));
  }
  ASSERT_TRUE(eventually([&] { return cell_.actions<api::PauseStream>().size() == 1; }));
  // Ten of the 200 increments end at points: 190 ticks of 4 ms.
  EXPECT_EQ(cell_.actions<api::PauseStream>().front().ends_at, std::chrono::milliseconds(760));
}

TEST_F(MotomanPorts, ANewClientTakesThePlaceOfAnIdleOneOnly) {
  SimpleMessageClient first(ports_.motion);
  start_mode(first);
  SimpleMessageClient second(ports_.motion);
  EXPECT_EQ(start_mode(second), (Outcome{0, 0}));
  EXPECT_TRUE(first.ended());
  send(second, point(0, 0));
  send(second, point(1, 0.5F));
  SimpleMessageClient third(ports_.motion);
  EXPECT_TRUE(third.ended());
  EXPECT_EQ(control(second, MotionCommand::kCheckMotionReady), (Outcome{0, 0}));
}

// ---- other requests

TEST_F(MotomanPorts, ServosAndAlarms) {
  SimpleMessageClient client(ports_.motion);
  EXPECT_EQ(control(client, MotionCommand::kStopServos), (Outcome{0, 0}));
  EXPECT_EQ(status().drives_powered, 0);
  EXPECT_EQ(control(client, MotionCommand::kCheckMotionReady), (Outcome{2, 5006}));
  EXPECT_EQ(control(client, MotionCommand::kStartServos), (Outcome{0, 0}));
  EXPECT_EQ(status().drives_powered, 1);
  change([](auto& robot) { robot.protective_stop = true; });
  EXPECT_EQ(status().in_error, 1);
  EXPECT_EQ(status().error_code, 4315);
  EXPECT_EQ(control(client, MotionCommand::kResetAlarm), (Outcome{0, 0}));
  EXPECT_EQ(status().in_error, 0);
}

TEST_F(MotomanPorts, UnknownRequestsAreAnsweredAndTheConnectionStays) {
  SimpleMessageClient client(ports_.motion);
  client.send_bytes(encode_word(20, ByteOrder::kBig) + encode_word(9999, ByteOrder::kBig) +
                    std::string(16, '\0'));
  const auto reply = client.receive_body<MotionReply>();
  EXPECT_EQ(reply.group, -1);
  EXPECT_EQ(reply.sequence, -1);
  EXPECT_EQ(reply.command, 9999);
  EXPECT_EQ(outcome_of(reply), (Outcome{3, 3003}));
  EXPECT_EQ(outcome_of(client.ask<MotionReply>(MessageType::kReadRegister, ReadIo{1})),
            (Outcome{3, 3003}))
      << "registers are the I/O server's";
  EXPECT_EQ(control(client, static_cast<MotionCommand>(200199)), (Outcome{3, 3006}));
  client.ask<Ping>(MessageType::kPing, Ping{});
  client.ask<DhParameters>(MessageType::kDhParameters, GetDhParameters{});
}

TEST_F(MotomanPorts, WhatOnlyAControllerSendsEndsTheConnection) {
  for (const auto& [type, body] :
       {std::pair<MessageType, Body>{MessageType::kRobotStatus, RobotStatus{}},
        std::pair<MessageType, Body>{MessageType::kJointFeedback, JointFeedback{}},
        std::pair<MessageType, Body>{MessageType::kMotionReply, MotionReply{}}}) {
    SimpleMessageClient client(ports_.motion);
    client.send({type, Communication::kTopic, ReplyCode::kNone, body});
    EXPECT_TRUE(client.ended());
  }
}

TEST_F(MotomanPorts, ToolsAreChecked) {
  SimpleMessageClient client(ports_.motion);
  const auto select = [&](std::int32_t group, std::int32_t tool) {
    return outcome_of(
        client.ask<MotionReply>(MessageType::kSelectTool, SelectTool{group, tool, 1}));
  };
  EXPECT_EQ(select(0, 63), (Outcome{0, 0}));
  EXPECT_EQ(select(0, 64), (Outcome{3, 3017}));
  EXPECT_EQ(select(1, 0), (Outcome{3, 3004}));
}

TEST_F(MotomanPorts, RequestsInPiecesAndInARowAreAllAnswered) {
  SimpleMessageClient client(ports_.motion);
  std::string bytes;
  for (int i = 0; i < 40; ++i) {
    bytes += encode({MessageType::kMotionControl, Communication::kServiceRequest, ReplyCode::kNone,
                     MotionControl{0, i, 200102, {}}},
                    ByteOrder::kBig);
  }
  for (std::size_t at = 0; at < bytes.size(); at += 37) client.send_bytes(bytes.substr(at, 37));
  for (int i = 0; i < 40; ++i) EXPECT_EQ(client.receive_body<MotionReply>().sequence, i);
}

// ---- states

TEST_F(MotomanPorts, FeedbackAndStatusComeTogether) {
  change([](auto& robot) {
    robot.joints[6].position_rad = 0.5;
    robot.joints[6].velocity_rad_s = -0.25;
    robot.motion.reference_rad[6] = 0.5;
  });
  SimpleMessageClient client(ports_.state);
  for (int i = 0; i < 3; ++i) {
    const auto feedback = client.receive_body<JointFeedback>();
    EXPECT_EQ(feedback.valid, kPositionValid | kVelocityValid);
    EXPECT_EQ(feedback.time, 0);
    EXPECT_NEAR(feedback.position[6], 0.5, std::numbers::pi / 180 / 580.27);
    EXPECT_FLOAT_EQ(feedback.velocity[6], -0.25F);
    EXPECT_EQ(feedback.acceleration, Joints{});
    EXPECT_EQ(client.receive_body<RobotStatus>().in_motion, 0);
  }
}

TEST_F(MotomanPorts, ARobotThatLagsIsInMotion) {
  change([](auto& robot) { robot.motion.reference_rad[0] = 0.001; });
  EXPECT_EQ(status().in_motion, 1);
}

TEST_F(MotomanPorts, AnEmergencyStopIsNoAlarm) {
  faults_.begin(faults::Kind::kRobotEmergencyStop, 1);
  const RobotStatus now = status();
  EXPECT_EQ(now.e_stopped, 1);
  EXPECT_EQ(now.in_error, 0);
  EXPECT_EQ(now.drives_powered, 0);
}

TEST_F(MotomanPorts, FourClientsReadStatesAndAFifthTakesTheOldestsPlace) {
  std::vector<std::unique_ptr<SimpleMessageClient>> clients;
  for (int i = 0; i < 5; ++i) {
    clients.push_back(std::make_unique<SimpleMessageClient>(ports_.state));
    clients.back()->receive();
  }
  EXPECT_TRUE(clients.front()->ended());
  for (int i = 1; i < 5; ++i) clients[static_cast<std::size_t>(i)]->receive();
}

// ---- I/O

TEST_F(MotomanPorts, TheValvesMoveTheGripper) {
  SimpleMessageClient client(ports_.gripper);
  const auto settings = [&] {
    std::string text;
    for (const auto& set : cell_.actions<api::SwitchGripper>()) text += set.setting > 0 ? "o" : "c";
    return text;
  };
  EXPECT_EQ(write(client, 10012, 1), 0);
  EXPECT_EQ(read(client, 10010), 1);
  EXPECT_EQ(settings(), "o");
  EXPECT_EQ(write(client, 10010, 0), 0);
  EXPECT_EQ(settings(), "o");
  EXPECT_EQ(write(client, 10011, 1), 0);
  EXPECT_EQ(settings(), "oc");
  EXPECT_EQ(read(client, 10010), 0);
  EXPECT_EQ(write(client, 10010, 1), 0);
  EXPECT_EQ(settings(), "oc") << "both valves are on";
  EXPECT_EQ(write(client, 10011, 0), 0);
  EXPECT_EQ(settings(), "oco");
  EXPECT_EQ(write(client, 10012, 0), 0);
  EXPECT_EQ(write(client, 10010, 0), 0);
  EXPECT_EQ(write(client, 10011, 1), 0);
  EXPECT_EQ(settings(), "oco") << "without air";
}

TEST_F(MotomanPorts, SignalsAndRegisters) {
  SimpleMessageClient client(ports_.gripper);
  EXPECT_EQ(write(client, 10020, 1), 0);
  EXPECT_EQ(read(client, 10020), 1);
  EXPECT_EQ(write(client, 10018, 1), 1002);
  EXPECT_EQ(write(client, 10020, 2), 1003);
  EXPECT_EQ(client.ask<ReadIoReply>(MessageType::kReadIoBit, ReadIo{5}).result, 1001);
  EXPECT_EQ(client.ask<WriteIoReply>(MessageType::kWriteIoGroup, WriteIo{1003, 0xA5}).result, 0);
  EXPECT_EQ(client.ask<ReadIoReply>(MessageType::kReadIoGroup, ReadIo{1003}).value, 0xA5);
  EXPECT_EQ(read(client, 10032), 1);
  EXPECT_EQ(client.ask<WriteIoReply>(MessageType::kWriteRegister, WriteIo{7, 4242}).result, 0);
  EXPECT_EQ(client.ask<ReadIoReply>(MessageType::kReadRegister, ReadIo{1000007}).value, 4242);
  client.send(
      {MessageType::kReadIoBit, Communication::kServiceRequest, ReplyCode::kNone, ReadIo{5}});
  EXPECT_EQ(client.receive().reply, ReplyCode::kFailure);
}

TEST_F(MotomanPorts, ASignalShowsThatTrajectoriesAreTaken) {
  SimpleMessageClient io(ports_.gripper), client(ports_.motion);
  EXPECT_EQ(read(io, 11120), 0);
  start_mode(client);
  EXPECT_EQ(read(io, 11120), 1);
  EXPECT_EQ(read(client, 11120), 1) << "the motion port answers, too";
}

TEST_F(MotomanPorts, AnUnknownTypeOnTheIoPortHasResultAndSubcodeInFront) {
  SimpleMessageClient client(ports_.gripper);
  client.send({MessageType::kMotionControl, Communication::kServiceRequest, ReplyCode::kNone,
               MotionControl{}});
  const std::string bytes = client.receive_bytes();
  EXPECT_EQ(bytes.substr(0, 8),
            encode_word(72, ByteOrder::kBig) + encode_word(2002, ByteOrder::kBig));
  EXPECT_EQ(bytes.substr(16, 8),
            encode_word(3, ByteOrder::kBig) + encode_word(3003, ByteOrder::kBig));
  EXPECT_EQ(read(client, 10010), 1);
}

}  // namespace
}  // namespace aprsim::simple_message
