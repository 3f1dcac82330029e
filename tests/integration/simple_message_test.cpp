// The real daemon's Simple Message ports: where they are, and a run over them that is run again.

#include <cmath>
#include <csignal>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "proto/journal/frames.hpp"
#include "proto/journal/journal_reader.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/simple_message_client.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::test {
namespace {

using namespace simple_message;

const std::vector<std::string> kNames{"motion.fanuc",   "state.fanuc",   "gripper.fanuc",
                                      "motion.motoman", "state.motoman", "gripper.motoman"};

MotionReply control(SimpleMessageClient& client, MotionCommand command) {
  return client.ask<MotionReply>(MessageType::kMotionControl,
                                 MotionControl{0, 0, static_cast<std::int32_t>(command), {}});
}

std::optional<Joints> joints_in(const Message& message) {
  if (const auto* position = std::get_if<JointPosition>(&message.body)) return position->position;
  if (const auto* feedback = std::get_if<JointFeedback>(&message.body)) return feedback->position;
  return std::nullopt;
}

/// The present joints: a fresh connection has no old states.
Joints joints_now(std::uint16_t state_port) {
  SimpleMessageClient state(state_port);
  while (true) {
    if (const auto joints = joints_in(state.receive())) return *joints;
  }
}

/// Waits until the first joint is there and the robot says that it stands.
void wait_at(std::uint16_t state_port, float angle_rad) {
  SimpleMessageClient state(state_port);
  const auto deadline = TcpSocket::Clock::now() + std::chrono::seconds(60);
  bool there = false;
  while (true) {
    ASSERT_LT(TcpSocket::Clock::now(), deadline);
    const Message message = state.receive();
    if (const auto joints = joints_in(message)) there = std::abs((*joints)[0] - angle_rad) < 0.01F;
    const auto* status = std::get_if<RobotStatus>(&message.body);
    if (status != nullptr && there && status->in_motion == 0) return;
  }
}

/// Moves the first joint of the Motoman by so much, a point each 0.1 s.
void swing_motoman(SimpleMessageClient& motion, std::uint16_t state_port, float angle_rad) {
  const Joints from = joints_now(state_port);
  constexpr int kPoints = 10;
  for (int i = 0; i <= kPoints;) {
    const float share = static_cast<float>(i) / kPoints;
    const float smooth = share * share * (3 - 2 * share);
    TrajectoryPointFull point{0, i, 7, 0.1F * static_cast<float>(i), from, {}, {}};
    point.position[0] += smooth * angle_rad;
    point.velocity[0] = 6 * share * (1 - share) * angle_rad;
    const auto reply = motion.ask<MotionReply>(MessageType::kTrajectoryPointFull, point);
    ASSERT_LE(reply.result, 1) << reply.subcode;
    if (reply.result == 0) ++i;
  }
  wait_at(state_port, from[0] + angle_rad);
}

void move_fanuc(SimpleMessageClient& motion, std::uint16_t state_port, float angle_rad) {
  Joints to = joints_now(state_port);
  to[0] += angle_rad;
  for (int i = 0; i < 3; ++i) {
    motion.send({MessageType::kTrajectoryPoint, Communication::kServiceRequest, ReplyCode::kNone,
                 TrajectoryPoint{i, to, 0.1F, 10}});
    motion.receive();
  }
  wait_at(state_port, to[0]);
}

TEST(SimpleMessageDaemon, OnlyScenesThatSaySoHaveThePorts) {
  const DaemonProcess without({"--no-web"});
  const DaemonProcess with({"--no-web", "--scene", "aprs_2024"});
  for (const std::string& name : kNames) {
    EXPECT_FALSE(without.ports().contains(name)) << name;
    EXPECT_TRUE(with.ports().contains(name)) << name;
  }
}

TEST(SimpleMessageDaemon, AnAlarmIsLoggedOnceWithItsPeer) {
  const DaemonProcess daemon({"--no-web", "--scene", "aprs_2024"});
  SimpleMessageClient motion(daemon.port("motion.motoman"));
  ASSERT_EQ(control(motion, MotionCommand::kStartTrajectoryMode).result, 0);
  const Joints from = joints_now(daemon.port("state.motoman"));
  for (const int i : {0, 1, 2}) {
    // Accepted by the controller, and too fast for the arm.
    TrajectoryPointFull point{0, i, 7, 0.02F * static_cast<float>(i), from, {}, {}};
    point.position[0] += 0.1F * static_cast<float>(i);
    const auto reply = motion.ask<MotionReply>(MessageType::kTrajectoryPointFull, point);
    EXPECT_TRUE(reply.result == 0 || reply.result == 5) << reply.result << " " << reply.subcode;
  }
  // Told, and not again when others see the stopped robot.
  const auto lines = [&] {
    const std::string log = daemon.log();
    std::size_t count = 0;
    for (auto at = log.find("ends in an alarm"); at != std::string::npos;
         at = log.find("ends in an alarm", at + 1)) {
      ++count;
    }
    return count;
  };
  ASSERT_TRUE(eventually([&] { return lines() > 0; }));
  EXPECT_EQ(control(motion, MotionCommand::kCheckMotionReady).subcode, 5001);
  (void)joints_now(daemon.port("state.motoman"));
  EXPECT_EQ(lines(), 1U);
  const std::string log = daemon.log();
  const auto line = log.substr(log.rfind('\n', log.find("ends in an alarm")) + 1);
  EXPECT_NE(line.find("simple_message.motoman"), std::string::npos) << line;
  EXPECT_NE(line.find("127.0.0.1:"), std::string::npos) << line;
  EXPECT_NE(line.find("joint_s: speed"), std::string::npos) << line;
}

TEST(SimpleMessageDaemon, ARunOverItsPortsIsTheSameAgain) {
  const TemporaryDirectory directory;
  const std::string file = directory.path() + "/run.journal";
  {
    DaemonProcess daemon({"--no-web", "--scene", "aprs_2024", "--journal", file});
    SimpleMessageClient motion(daemon.port("motion.motoman")), fanuc(daemon.port("motion.fanuc"));
    ASSERT_EQ(control(motion, MotionCommand::kStartTrajectoryMode).result, 0);
    for (const float angle : {0.2F, -0.2F}) {
      swing_motoman(motion, daemon.port("state.motoman"), angle);
      move_fanuc(fanuc, daemon.port("state.fanuc"), angle);
    }
    EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  }
  const auto again =
      run_process({std::string(APRSIM_BIN_DIR) + "/aprsimd", "--replay", file, "--json"},
                  std::chrono::seconds(300));
  const auto found = nlohmann::json::parse(again.out);
  EXPECT_EQ(again.exit_code, 0) << again.out;
  EXPECT_GT(found["replies"], 20) << again.out;

  // A state with another joint is found.
  auto reader = journal::JournalReader::open(file);
  ASSERT_TRUE(reader.has_value());
  journal::FrameEncoder encoder;
  v1::JournalRecord record;
  *record.mutable_header() = reader->header();
  encoder.add(record);
  std::string bytes = std::string(journal::kMagic) + encoder.take();
  int states = 0;
  while (reader->next(record)) {
    if (record.has_wire() && record.wire().listener() == "state.motoman" &&
        record.wire().content() == v1::WIRE_CONTENT_SENT && record.wire().data().size() == 148 &&
        ++states == 40) {
      constexpr std::size_t kThirdJoint = 36;
      record.mutable_wire()->mutable_data()->replace(kThirdJoint, 4, "\x3f\x80\x00\x01", 4);
    }
    encoder.add(record);
    bytes += encoder.take();
  }
  ASSERT_GE(states, 40);
  const std::string changed = directory.path() + "/changed.journal";
  std::ofstream(changed, std::ios::binary) << bytes;
  const auto other =
      run_process({std::string(APRSIM_BIN_DIR) + "/aprsimd", "--replay", changed, "--json"},
                  std::chrono::seconds(300));
  EXPECT_EQ(other.exit_code, 1) << other.out;
  EXPECT_NE(other.out.find("position of joint 3"), std::string::npos) << other.out;
}

}  // namespace
}  // namespace aprsim::test
