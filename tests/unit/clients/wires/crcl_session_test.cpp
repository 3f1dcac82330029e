#include "clients/wires/crcl_session.hpp"

#include <atomic>

#include <gtest/gtest.h>

#include "tests/unit/clients/aprsim/scripted_robot.hpp"

namespace aprsim::client {
namespace {

using namespace std::chrono_literals;

Endpoints robot_at(std::uint16_t port) {
  Endpoints endpoints;
  endpoints.crcl = {{"scout", port}};
  return endpoints;
}

TEST(CrclSession, NumbersItsCommandsOnFromTheRobotsLastOne) {
  const test::ScriptedRobot robot(
      [](const crcl::Command& command) {
        return crcl::CommandStatus{.command_id = command.id, .state = crcl::CommandState::kDone};
      },
      50);
  auto session = CrclSession::connect(robot_at(robot.port()), "scout");
  ASSERT_TRUE(session) << session.error().message;
  ASSERT_TRUE(session->run(crcl::InitCanon{}, 30s));
  const auto status = session->run(crcl::Dwell{0.5}, 30s);
  ASSERT_TRUE(status) << status.error().message;
  EXPECT_EQ(status->command.command_id, 52);
}

TEST(CrclSession, ACommandThatIsCancelledIsStopped) {
  std::atomic<bool> cancelled = false;
  const test::ScriptedRobot robot([&](const crcl::Command& command) {
    // A dwell does not end, and is cancelled once the robot has it.
    const bool dwells = std::holds_alternative<crcl::Dwell>(command.body);
    if (dwells) cancelled = true;
    return crcl::CommandStatus{
        .command_id = command.id,
        .state = dwells ? crcl::CommandState::kWorking : crcl::CommandState::kDone};
  });
  auto session =
      CrclSession::connect(robot_at(robot.port()), "scout", [&] { return cancelled.load(); });
  ASSERT_TRUE(session) << session.error().message;
  const auto done = session->run(crcl::Dwell{1000}, 1h);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().kind, FailureKind::kInterrupted);
  const auto stopped = session->stopped_after(done.error());
  EXPECT_EQ(stopped.kind, FailureKind::kInterrupted);
  EXPECT_EQ(stopped.message, "interrupted; scout has stopped");
  EXPECT_TRUE(std::holds_alternative<crcl::StopMotion>(robot.commands().back().body));
  // No further command is sent.
  const std::size_t sent = robot.commands().size();
  EXPECT_EQ(session->run(crcl::Dwell{1}, 1h).error().kind, FailureKind::kInterrupted);
  EXPECT_EQ(robot.commands().size(), sent);
}

TEST(CrclSession, AFailureThatIsNoCancellationStaysAsItIs) {
  const test::ScriptedRobot robot([](const crcl::Command& command) {
    return crcl::CommandStatus{.command_id = command.id,
                               .state = crcl::CommandState::kError,
                               .description = "joint 3 is at its limit"};
  });
  auto session = CrclSession::connect(robot_at(robot.port()), "scout", [] { return false; });
  ASSERT_TRUE(session) << session.error().message;
  const auto done = session->run(crcl::InitCanon{}, 30s);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().kind, FailureKind::kRefused);
  const auto failure = session->stopped_after(done.error());
  EXPECT_EQ(failure.kind, FailureKind::kRefused);
  EXPECT_NE(failure.message.find("joint 3 is at its limit"), std::string::npos);
}

}  // namespace
}  // namespace aprsim::client
