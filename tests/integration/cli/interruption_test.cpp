#include <cmath>
#include <csignal>

#include <gtest/gtest.h>

#include "tests/integration/cli/cli_commands.hpp"
#include "tests/support/cell_client.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/terminal_process.hpp"

namespace aprsim::test {
namespace {

constexpr double kMoves_rad_s = 0.05;

const v1::RobotState& robot(const v1::Snapshot& snapshot, const std::string& name) {
  for (const auto& one : snapshot.robots()) {
    if (one.name() == name) return one;
  }
  throw std::runtime_error("no " + name);
}

bool moves(const v1::Snapshot& snapshot, const std::string& name) {
  for (const auto& joint : robot(snapshot, name).joints()) {
    if (std::abs(joint.velocity_rad_s()) > kMoves_rad_s) return true;
  }
  return false;
}

/// Nothing of the robot moves from here on for half a second of its time.
void expect_standstill(CellClient& client, const std::string& name) {
  const auto before = client.snapshot();
  const auto after = client.wait_for(
      [&](const v1::Snapshot& now) { return now.step() > before.step() + 500; }, "half a second");
  for (int i = 0; i < robot(before, name).joints_size(); ++i) {
    EXPECT_NEAR(robot(after, name).joints(i).position_rad(),
                robot(before, name).joints(i).position_rad(), 1e-5)
        << name << ", joint " << i + 1;
  }
  EXPECT_FALSE(moves(after, name));
}

class Interruption : public testing::Test {
 protected:
  DaemonProcess daemon_;
  CellClient client_{daemon_.port("grpc")};

  TerminalProcess start(const std::vector<std::string>& arguments) const {
    return TerminalProcess(cli_command(daemon_, arguments));
  }
  /// A jog of three seconds, under way.
  TerminalProcess start_jog() {
    return start({"crcl", "jog", "--robot", "fanuc", "--init", "--joint", "1", "--by", "60",
                  "--speed", "20"});
  }
  void wait_until_moving(const std::string& name) {
    client_.wait_for([&](const v1::Snapshot& now) { return moves(now, name); }, name + " to move");
  }
};

TEST_F(Interruption, CtrlCStopsAJog) {
  auto jog = start_jog();
  wait_until_moving("fanuc");
  jog.type("\x03");
  // It dies of the signal itself, so that a shell ends the loop around it: 130 there.
  EXPECT_EQ(jog.wait_for_exit(), -SIGINT) << jog.output();
  EXPECT_FALSE(moves(client_.snapshot(), "fanuc")) << "stopped before it left";
  expect_standstill(client_, "fanuc");
  EXPECT_LT(robot(client_.snapshot(), "fanuc").joints(0).position_rad(), 1.0) << "not to its end";
  EXPECT_NE(jog.output().find("interrupted; fanuc has stopped"), std::string::npos) << jog.output();
  EXPECT_TRUE(robot(client_.snapshot(), "fanuc").drives_on());
}

TEST_F(Interruption, SigtermStopsAJog) {
  auto jog = start_jog();
  wait_until_moving("fanuc");
  jog.send(SIGTERM);
  EXPECT_EQ(jog.wait_for_exit(), 130) << jog.output();
  expect_standstill(client_, "fanuc");
}

TEST_F(Interruption, AShellSees130AndEndsItsLoop) {
  TerminalProcess shell({"bash", "-c", "for i in 1 2 3; do \"$@\"; echo code $?; done", "bash",
                         std::string(APRSIM_BIN_DIR) + "/aprsim", "--ports-file",
                         daemon_.ports_file(), "crcl", "jog", "--robot", "fanuc", "--init",
                         "--joint", "1", "--by", "60", "--speed", "20"});
  wait_until_moving("fanuc");
  shell.type("\x03");
  EXPECT_EQ(shell.wait_for_exit(), -SIGINT);
  EXPECT_EQ(shell.output().find("code"), std::string::npos) << shell.output();
  expect_standstill(client_, "fanuc");
}

TEST_F(Interruption, SecondSignalExitsAtOnce) {
  auto jog = start_jog();
  wait_until_moving("fanuc");
  // A daemon that answers nothing: the stop waits for its timeout, but for the second Ctrl-C.
  kill(daemon_.pid(), SIGSTOP);
  const auto began = std::chrono::steady_clock::now();
  EXPECT_TRUE(eventually([&] {
    jog.send(SIGINT);
    return jog.has_ended();
  }));
  kill(daemon_.pid(), SIGCONT);
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(3));
  EXPECT_EQ(jog.wait_for_exit(), -SIGINT);
}

TEST_F(Interruption, UnresponsiveDaemonIsReported) {
  auto jog = start_jog();
  wait_until_moving("fanuc");
  kill(daemon_.pid(), SIGSTOP);
  jog.send(SIGINT);
  const int exit_code = jog.wait_for_exit(TerminalProcess::Seconds(40));
  kill(daemon_.pid(), SIGCONT);
  EXPECT_EQ(exit_code, -SIGINT);
  EXPECT_NE(jog.output().find("MAY STILL MOVE"), std::string::npos) << jog.output();
}

TEST_F(Interruption, AJogThatTakesTooLongIsStopped) {
  auto jog = start({"crcl", "jog", "--robot", "fanuc", "--init", "--joint", "1", "--by", "60",
                    "--speed", "5", "--timeout", "0.5"});
  EXPECT_EQ(jog.wait_for_exit(), 4) << jog.output();
  EXPECT_FALSE(moves(client_.snapshot(), "fanuc"));
  expect_standstill(client_, "fanuc");
}

TEST_F(Interruption, CtrlCStopsAProgram) {
  auto program = start({"crcl", "run", example("wave.xml"), "--robot", "fanuc"});
  wait_until_moving("fanuc");
  program.type("\x03");
  EXPECT_EQ(program.wait_for_exit(), -SIGINT);
  EXPECT_FALSE(moves(client_.snapshot(), "fanuc"));
  expect_standstill(client_, "fanuc");
  EXPECT_EQ(program.output().find("EndCanon"), std::string::npos) << program.output();
}

TEST_F(Interruption, CtrlCStopsTheDemoAndSaysWhatItHolds) {
  auto demo = start({"demo", "--robot", "fanuc"});
  demo.wait_for("lifted it", TerminalProcess::Seconds(60));
  wait_until_moving("fanuc");
  demo.type("\x03");
  EXPECT_EQ(demo.wait_for_exit(), -SIGINT);
  EXPECT_FALSE(moves(client_.snapshot(), "fanuc"));
  expect_standstill(client_, "fanuc");
  const auto held = robot(client_.snapshot(), "fanuc").gripper().held_body();
  ASSERT_FALSE(held.empty());
  EXPECT_NE(demo.output().find(", holding " + held), std::string::npos) << demo.output();
}

TEST_F(Interruption, CtrlCStopsTheDemosBelt) {
  auto demo = start({"demo", "--belt"});
  client_.wait_for(
      [](const v1::Snapshot& now) { return std::abs(now.conveyor().speed_m_s()) > 0.05; },
      "the belt to run");
  demo.type("\x03");
  EXPECT_EQ(demo.wait_for_exit(), -SIGINT);
  const auto now = client_.snapshot();
  EXPECT_FALSE(now.conveyor().run());
  EXPECT_EQ(now.conveyor().speed_m_s(), 0);
  EXPECT_NE(demo.output().find("the belt has stopped"), std::string::npos) << demo.output();
}

TEST_F(Interruption, AReaderThatLeavesStopsTheDemo) {
  TerminalProcess shell({"bash", "-c", "\"$@\" | head -n 1", "bash",
                         std::string(APRSIM_BIN_DIR) + "/aprsim", "--ports-file",
                         daemon_.ports_file(), "demo", "--robot", "fanuc"});
  EXPECT_EQ(shell.wait_for_exit(TerminalProcess::Seconds(60)), 0);
  expect_standstill(client_, "fanuc");
}

TEST_F(Interruption, CommandsWithoutMotionExitAtOnce) {
  for (const auto& [signal, exit_code] : {std::pair(SIGINT, -SIGINT), std::pair(SIGTERM, 130)}) {
    auto watch = start({"watch", "--json"});
    watch.wait_for("\"step\"");
    watch.send(signal);
    EXPECT_EQ(watch.wait_for_exit(), exit_code);
  }
}

}  // namespace
}  // namespace aprsim::test
