// The real daemon's Simple Message ports: where they are, and a run over them that is run again.

#include <csignal>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "proto/journal/frames.hpp"
#include "proto/journal/journal_reader.hpp"
#include "tests/support/daemon_process.hpp"
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

Joints joints_of(SimpleMessageClient& state) {
  while (true) {
    const Message message = state.receive();
    if (const auto* position = std::get_if<JointPosition>(&message.body)) {
      return position->position;
    }
    if (const auto* feedback = std::get_if<JointFeedback>(&message.body)) {
      return feedback->position;
    }
  }
}

/// Moves the first joint of the Motoman by so much, a point each 0.1 s, and waits for it.
void swing_motoman(SimpleMessageClient& motion, SimpleMessageClient& state, float angle_rad) {
  const Joints from = joints_of(state);
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
    joints_of(state);
  }
  const auto deadline = TcpSocket::Clock::now() + std::chrono::seconds(60);
  while (std::abs(joints_of(state)[0] - from[0] - angle_rad) > 0.01F) {
    ASSERT_LT(TcpSocket::Clock::now(), deadline);
  }
}

void move_fanuc(SimpleMessageClient& motion, SimpleMessageClient& state, float angle_rad) {
  Joints to = joints_of(state);
  to[0] += angle_rad;
  for (int i = 0; i < 3; ++i) {
    motion.send({MessageType::kTrajectoryPoint, Communication::kServiceRequest, ReplyCode::kNone,
                 TrajectoryPoint{i, to, 0.1F, 10}});
    motion.receive();
  }
  const auto deadline = TcpSocket::Clock::now() + std::chrono::seconds(60);
  while (std::abs(joints_of(state)[0] - to[0]) > 0.01F) {
    ASSERT_LT(TcpSocket::Clock::now(), deadline);
  }
}

TEST(SimpleMessageDaemon, OnlyScenesThatSaySoHaveThePorts) {
  const DaemonProcess without({"--no-web"});
  const DaemonProcess with({"--no-web", "--scene", "aprs_2024"});
  for (const std::string& name : kNames) {
    EXPECT_FALSE(without.ports().contains(name)) << name;
    EXPECT_TRUE(with.ports().contains(name)) << name;
  }
}

TEST(SimpleMessageDaemon, ARunOverItsPortsIsTheSameAgain) {
  const TemporaryDirectory directory;
  const std::string file = directory.path() + "/run.journal";
  {
    DaemonProcess daemon({"--no-web", "--scene", "aprs_2024", "--journal", file});
    SimpleMessageClient motion(daemon.port("motion.motoman")), state(daemon.port("state.motoman"));
    SimpleMessageClient fanuc(daemon.port("motion.fanuc")), other(daemon.port("state.fanuc"));
    ASSERT_EQ(control(motion, MotionCommand::kStartTrajectoryMode).result, 0);
    for (const float angle : {0.2F, -0.2F}) {
      swing_motoman(motion, state, angle);
      move_fanuc(fanuc, other, angle);
    }
    EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  }
  const auto again =
      run_process({std::string(APRSIM_BIN_DIR) + "/aprsimd", "--replay", file, "--json"},
                  std::chrono::seconds(300));
  const auto found = nlohmann::json::parse(again.out);
  EXPECT_EQ(again.exit_code, 0) << again.out;
  EXPECT_GT(found["replies"], 100) << again.out;

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
