#include <cmath>
#include <optional>

#include "tests/unit/protocols/web/web_fixture.hpp"

namespace aprsim {
namespace {

using test::RawWebClient;

class Jog : public test::WebFixture {
 protected:
  void SetUp() override {
    options.jog_timeout = std::chrono::minutes(1);  // no jog ends of itself
    world.publish([](api::Snapshot& s) {
      for (auto& robot : s.robots) robot.initialized = true;
    });
    start();
  }

  static v1::ViewerRequest joint(std::uint32_t joint, bool negative = false) {
    v1::ViewerRequest request;
    request.mutable_jog()->set_robot(1);
    request.mutable_jog()->set_speed(0.2);
    request.mutable_jog()->mutable_joint()->set_joint(joint);
    request.mutable_jog()->mutable_joint()->set_negative(negative);
    return request;
  }
  static v1::ViewerRequest along_x() {
    v1::ViewerRequest request;
    request.mutable_jog()->set_robot(1);
    request.mutable_jog()->set_speed(0.1);
    request.mutable_jog()->mutable_tool()->mutable_along()->set_x(1);
    return request;
  }
  static v1::ViewerRequest release() {
    v1::ViewerRequest request;
    request.mutable_jog()->set_robot(1);
    return request;
  }
  static v1::ViewerRequest step(v1::ViewerRequest request, std::uint32_t id, double way) {
    request.set_id(id);
    request.mutable_jog()->set_step(way);
    return request;
  }
  static v1::Outcome outcome(RawWebClient& client, std::uint32_t id) {
    const auto update =
        client.next([&](const auto& u) { return u.has_outcome() && u.outcome().id() == id; });
    return update ? update->outcome() : v1::Outcome();
  }

  [[nodiscard]] api::RobotAction action(std::size_t index) const {
    const auto command = std::get<api::RobotCommand>(world.commands().at(index).body);
    EXPECT_EQ(command.robot, 1);
    return command.action;
  }
};

TEST_F(Jog, MovesAJointUntilReleased) {
  RawWebClient client(port);
  (void)client.upgrade();
  ASSERT_TRUE(client.ask(joint(2, true)).ok());
  const auto move = std::get<api::MoveJoints>(action(0));
  ASSERT_EQ(move.targets.size(), 1u);
  EXPECT_EQ(move.targets[0].joint, 2);
  EXPECT_EQ(move.targets[0].position_rad, -3);
  EXPECT_DOUBLE_EQ(*move.targets[0].speed_rad_s, 0.2);
  world.report(1, 1, api::ActionState::kWorking);
  world.publish([](api::Snapshot& s) { s.robots[1].moving = true; });
  ASSERT_TRUE(client.ask(joint(2, true)).ok());
  EXPECT_EQ(world.commands().size(), 1u) << "renewing sends nothing";
  ASSERT_TRUE(client.ask(release()).ok());
  ASSERT_EQ(world.commands().size(), 2u);
  EXPECT_TRUE(std::holds_alternative<api::StopMotion>(action(1)));
}

TEST_F(Jog, StopsWhenItIsNotRenewed) {
  options.jog_timeout = std::chrono::milliseconds(200);
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  ASSERT_TRUE(client.ask(joint(0)).ok());
  ASSERT_TRUE(world.wait_for_commands(2));
  EXPECT_TRUE(std::holds_alternative<api::StopMotion>(action(1)));
}

TEST_F(Jog, StopsWhenTheSocketDrops) {
  {
    RawWebClient client(port);
    (void)client.upgrade();
    ASSERT_TRUE(client.ask(joint(0)).ok());
  }
  ASSERT_TRUE(world.wait_for_commands(2));
  EXPECT_TRUE(std::holds_alternative<api::StopMotion>(action(1)));
}

TEST_F(Jog, StopsWhenTheServerStops) {
  RawWebClient client(port);
  (void)client.upgrade();
  ASSERT_TRUE(client.ask(joint(0)).ok());
  server->stop();
  ASSERT_EQ(world.commands().size(), 2u);
  EXPECT_TRUE(std::holds_alternative<api::StopMotion>(action(1)));
}

TEST_F(Jog, BelongsToOneViewer) {
  RawWebClient client(port), other(port);
  (void)client.upgrade();
  (void)other.upgrade();
  ASSERT_TRUE(client.ask(joint(0)).ok());
  EXPECT_EQ(other.ask(joint(1)).message(), "another viewer is jogging this robot");
  EXPECT_TRUE(other.ask(release()).ok());
  EXPECT_EQ(world.commands().size(), 1u) << "nobody stops another's jog by releasing nothing";
}

TEST_F(Jog, ATurnOfTheButtonStopsAndGoesTheOtherWay) {
  RawWebClient client(port);
  (void)client.upgrade();
  ASSERT_TRUE(client.ask(joint(0)).ok());
  ASSERT_TRUE(client.ask(joint(0, true)).ok());
  ASSERT_EQ(world.commands().size(), 2u) << "from rest only";
  EXPECT_TRUE(std::holds_alternative<api::StopMotion>(action(1)));
  world.report(1, 2, api::ActionState::kDone);
  ASSERT_TRUE(world.wait_for_commands(3));
  EXPECT_EQ(std::get<api::MoveJoints>(action(2)).targets[0].position_rad, -3);
}

TEST_F(Jog, ACommandFromElsewhereEndsItWithoutAStop) {
  RawWebClient client(port);
  (void)client.upgrade();
  ASSERT_TRUE(client.ask(joint(0)).ok());
  world.report(1, 99, api::ActionState::kWorking);
  (void)client.next([](const auto& u) {
    return u.has_snapshot() && u.snapshot().robots(1).action().ticket() == 99;
  });
  const auto again = client.ask(joint(0));
  EXPECT_NE(again.message().find("taken over the robot"), std::string::npos) << again.message();
  EXPECT_TRUE(client.ask(release()).ok());
  EXPECT_EQ(world.commands().size(), 1u);
  EXPECT_TRUE(client.ask(joint(0)).ok()) << "pressed anew";
}

TEST_F(Jog, ToolStretchesShrinkWhileTheRobotRefusesThem) {
  RawWebClient client(port);
  (void)client.upgrade();
  ASSERT_TRUE(client.ask(along_x()).ok());
  ASSERT_EQ(world.commands().size(), 1u);
  const double first = std::get<api::MoveTo>(action(0)).X_RT.p.x();
  EXPECT_TRUE(std::get<api::MoveTo>(action(0)).straight);
  world.report(1, 1, api::ActionState::kError, "out of reach");
  ASSERT_TRUE(world.wait_for_commands(3));
  EXPECT_TRUE(std::holds_alternative<api::InitRobot>(action(1)));
  EXPECT_DOUBLE_EQ(std::get<api::MoveTo>(action(2)).X_RT.p.x(), first / 2);
}

/// The robot's answer to a stretch and the end of its jog may meet.
class JogReleasedAtARefusal : public Jog {
 protected:
  void SetUp() override {
    Jog::SetUp();
    client_.emplace(port);
    (void)client_->upgrade();
  }
  /// The robot's report once the stop of the jog along x has been applied.
  void release_and_report(api::Ticket ticket, bool protective_stop) {
    ASSERT_TRUE(client_->ask(along_x()).ok());
    ASSERT_TRUE(client_->ask(release()).ok());
    ASSERT_EQ(world.commands().size(), 2u);
    EXPECT_TRUE(std::holds_alternative<api::StopMotion>(action(1)));
    world.publish([&](api::Snapshot& s) {
      s.robots[1].initialized = false;
      s.robots[1].protective_stop = protective_stop;
    });
    world.report(1, ticket, api::ActionState::kError, "out of reach");
  }
  /// Waits until the joggers have looked at what was published last.
  void expect_no_command_after(std::size_t count) {
    (void)client_->next([](const auto& u) {
      return u.has_snapshot() && u.snapshot().robots(1).action().description() == "out of reach";
    });
    EXPECT_FALSE(client_->ask(joint(0)).ok()) << "not ready";
    EXPECT_EQ(world.commands().size(), count);
  }

  std::optional<RawWebClient> client_;
};

TEST_F(JogReleasedAtARefusal, LeavesTheRobotReady) {
  release_and_report(2, false);
  ASSERT_TRUE(world.wait_for_commands(3));
  EXPECT_TRUE(std::holds_alternative<api::InitRobot>(action(2)));
}

TEST_F(JogReleasedAtARefusal, TheNextJogBeginsOnceItIsReady) {
  ASSERT_TRUE(client_->ask(along_x()).ok());
  ASSERT_TRUE(client_->ask(release()).ok());
  ASSERT_TRUE(client_->ask(joint(0)).ok());
  world.publish([](api::Snapshot& s) { s.robots[1].initialized = false; });
  world.report(1, 2, api::ActionState::kError, "out of reach");
  ASSERT_TRUE(world.wait_for_commands(3));
  EXPECT_TRUE(std::holds_alternative<api::InitRobot>(action(2)));
  world.publish([](api::Snapshot& s) { s.robots[1].initialized = true; });
  world.report(1, 3, api::ActionState::kDone);
  ASSERT_TRUE(world.wait_for_commands(4));
  EXPECT_TRUE(std::holds_alternative<api::MoveJoints>(action(3)));
}

TEST_F(JogReleasedAtARefusal, KeepsAProtectiveStop) {
  release_and_report(2, true);
  expect_no_command_after(2);
}

TEST_F(JogReleasedAtARefusal, KeepsTheErrorOfAnothersCommand) {
  release_and_report(99, false);
  expect_no_command_after(2);
}

TEST_F(JogReleasedAtARefusal, KeepsAFaultOfTheDrives) {
  world.publish([](api::Snapshot& s) { s.robots[1].drives_on = false; });
  release_and_report(2, false);
  expect_no_command_after(2);
}

// 0.25 m/s at the tool: the speed of a joint is that over the tool's distance from its axis.
TEST_F(Jog, NeverMovesTheToolFasterThanInManualMode) {
  world.publish([](api::Snapshot& s) {
    auto& joints = s.robots[1].joints;
    joints[0].tool_lever_m = 0.8;
    joints[6].tool_lever_m = 0.01;
  });
  RawWebClient client(port);
  (void)client.upgrade();
  const auto speed_of = [&](std::uint32_t index, std::size_t command) {
    auto request = joint(index);
    request.mutable_jog()->set_speed(1);
    EXPECT_TRUE(client.ask(request).ok());
    return *std::get<api::MoveJoints>(action(command)).targets.at(0).speed_rad_s;
  };
  EXPECT_DOUBLE_EQ(speed_of(0, 0), 0.25 / 0.8);
  ASSERT_TRUE(client.ask(release()).ok());
  world.report(1, 2, api::ActionState::kDone);
  EXPECT_DOUBLE_EQ(speed_of(6, 2), 1) << "nor turns it faster than 1 rad/s";
  ASSERT_TRUE(client.ask(release()).ok());
  world.report(1, 4, api::ActionState::kDone);
  auto request = along_x();
  request.mutable_jog()->set_speed(1);
  ASSERT_TRUE(client.ask(request).ok());
  const auto limits = std::get<api::MoveTo>(action(4)).limits;
  EXPECT_FALSE(limits.trans_speed->relative);
  EXPECT_DOUBLE_EQ(limits.trans_speed->value, 0.25);
  EXPECT_DOUBLE_EQ(limits.rot_speed->value, 1);
}

TEST_F(Jog, BeginsFromRestWhenTheRobotIsOnItsWay) {
  world.publish([](api::Snapshot& s) { s.robots[1].moving = true; });
  RawWebClient client(port);
  (void)client.upgrade();
  ASSERT_TRUE(client.ask(joint(0)).ok());
  ASSERT_EQ(world.commands().size(), 1u);
  EXPECT_TRUE(std::holds_alternative<api::StopMotion>(action(0)));
  world.report(1, 1, api::ActionState::kWorking);
  ASSERT_TRUE(client.ask(joint(0)).ok());
  EXPECT_EQ(world.commands().size(), 1u);
  world.publish([](api::Snapshot& s) { s.robots[1].moving = false; });
  world.report(1, 1, api::ActionState::kDone);
  ASSERT_TRUE(world.wait_for_commands(2));
  EXPECT_TRUE(std::holds_alternative<api::MoveJoints>(action(1)));
}

TEST_F(Jog, StepsAreMadeOneAfterTheOtherAndAnsweredAtTheirEnds) {
  world.publish([](api::Snapshot& s) { s.robots[1].joints[2].position_rad = 0.5; });
  RawWebClient client(port);
  (void)client.upgrade();
  client.send(step(joint(2, true), 101, 0.02));
  client.send(step(along_x(), 102, 0.001));
  ASSERT_TRUE(world.wait_for_commands(1));
  EXPECT_DOUBLE_EQ(std::get<api::MoveJoints>(action(0)).targets.at(0).position_rad, 0.48);
  world.report(1, 1, api::ActionState::kWorking);
  EXPECT_EQ(client.ask(joint(7)).field(), "joint") << "the second step has been taken";
  EXPECT_EQ(world.commands().size(), 1u);
  world.report(1, 1, api::ActionState::kDone);
  EXPECT_TRUE(outcome(client, 101).ok());
  ASSERT_TRUE(world.wait_for_commands(2));
  EXPECT_DOUBLE_EQ(std::get<api::MoveTo>(action(1)).X_RT.p.x(), 0.001);
  world.report(1, 2, api::ActionState::kDone);
  EXPECT_TRUE(outcome(client, 102).ok());
  EXPECT_TRUE(client.ask(release()).ok());
  EXPECT_EQ(world.commands().size(), 2u) << "nothing is left to be stopped";
}

TEST_F(Jog, AStepThatTheRobotRefusesEndsAllAndLeavesItReady) {
  RawWebClient client(port);
  (void)client.upgrade();
  client.send(step(along_x(), 101, 0.1));
  client.send(step(along_x(), 102, 0.1));
  ASSERT_TRUE(world.wait_for_commands(1));
  EXPECT_EQ(client.ask(joint(7)).field(), "joint");
  world.report(1, 1, api::ActionState::kError, "out of reach by 0.02 m");
  EXPECT_EQ(outcome(client, 101).message(), "out of reach by 0.02 m");
  EXPECT_FALSE(outcome(client, 102).ok());
  ASSERT_TRUE(world.wait_for_commands(2));
  EXPECT_TRUE(std::holds_alternative<api::InitRobot>(action(1)));
}

TEST_F(Jog, ARobotWithAnotherCommanderIsNotJogged) {
  RawWebClient client(port);
  (void)client.upgrade();
  world.publish([](api::Snapshot& s) {
    s.robots[1].motion.source = api::MotionSource::kStream;
    s.robots[1].motion.commander = "driver";
  });
  EXPECT_EQ(client.ask(joint(0)).message(),
            "driver has the robot by a stream of motions: stop it first.");
  EXPECT_TRUE(world.commands().empty());
}

TEST_F(Jog, AProtectiveStopInAStepIsHeld) {
  RawWebClient client(port);
  (void)client.upgrade();
  client.send(step(along_x(), 101, 0.1));
  ASSERT_TRUE(world.wait_for_commands(1));
  world.publish([](api::Snapshot& s) {
    s.robots[1].protective_stop = true;
    s.robots[1].initialized = false;
  });
  world.report(1, 1, api::ActionState::kError, "Protective stop");
  EXPECT_EQ(outcome(client, 101).message(), "Protective stop");
  EXPECT_EQ(world.commands().size(), 1u);
  EXPECT_NE(client.ask(joint(0)).message().find("not ready: make it ready first"),
            std::string::npos);
}

TEST_F(Jog, StepsEndWithACommandFromElsewhereAndWithTheirViewer) {
  {
    RawWebClient client(port);
    (void)client.upgrade();
    client.send(step(along_x(), 101, 0.1));
    ASSERT_TRUE(world.wait_for_commands(1));
    world.report(1, 99, api::ActionState::kWorking);
    EXPECT_NE(outcome(client, 101).message().find("taken over the robot"), std::string::npos);
    EXPECT_EQ(world.commands().size(), 1u);
    world.publish([](api::Snapshot& s) {  // tickets count on from the last command's
      s.applied = 1;
      s.robots[1].action = {1, api::ActionState::kDone, ""};
    });
    client.send(step(along_x(), 102, 0.1));
    ASSERT_TRUE(world.wait_for_commands(2));
  }
  ASSERT_TRUE(world.wait_for_commands(3));
  EXPECT_TRUE(std::holds_alternative<api::StopMotion>(action(2)));
}

TEST_F(Jog, StepsThatWaitAreLimited) {
  RawWebClient client(port);
  (void)client.upgrade();
  for (std::uint32_t i = 0; i < 21; ++i) client.send(step(joint(0), 101 + i, 0.01));
  client.send(step(joint(0), 200, 0.01));
  const auto refused = outcome(client, 200);
  EXPECT_EQ(refused.field(), "step");
  EXPECT_NE(refused.message().find("20 steps"), std::string::npos);
  EXPECT_EQ(world.commands().size(), 1u);
}

TEST_F(Jog, ReleasedAfterAProtectiveStopLeavesTheArmToBackOff) {
  RawWebClient client(port);
  (void)client.upgrade();
  ASSERT_TRUE(client.ask(along_x()).ok());
  world.publish([](api::Snapshot& s) {
    s.robots[1].protective_stop = true;
    s.robots[1].initialized = false;
    s.robots[1].moving = true;
  });
  world.report(1, 1, api::ActionState::kError, "Protective stop: the gripper touches the table");
  const auto stopped = client.next(
      [](const auto& u) { return u.has_snapshot() && u.snapshot().robots(1).moving(); });
  ASSERT_TRUE(stopped);
  EXPECT_NE(client.ask(along_x()).message().find("Protective stop"), std::string::npos);
  EXPECT_TRUE(client.ask(release()).ok());
  EXPECT_EQ(world.commands().size(), 1u);
}

TEST_F(Jog, BadJogsNameTheField) {
  RawWebClient client(port);
  (void)client.upgrade();
  EXPECT_EQ(client.ask(joint(7)).field(), "joint");
  auto request = along_x();
  request.mutable_jog()->mutable_tool()->mutable_along()->set_x(2);
  EXPECT_EQ(client.ask(request).field(), "axis");
  request = joint(0);
  request.mutable_jog()->set_speed(1.5);
  EXPECT_EQ(client.ask(request).field(), "speed");
  for (const double way : {-0.01, 0.6, std::nan("")}) {
    request = joint(0);
    request.mutable_jog()->set_step(way);
    EXPECT_EQ(client.ask(request).field(), "step") << way;
  }
  request = along_x();
  request.mutable_jog()->set_step(0.2);
  EXPECT_EQ(client.ask(request).field(), "step");
  request = release();
  request.mutable_jog()->set_step(0.01);
  request.mutable_jog()->set_speed(1);
  EXPECT_EQ(client.ask(request).field(), "direction");
  request = joint(0);
  request.mutable_jog()->set_robot(9);
  EXPECT_EQ(client.ask(request).field(), "robot");
  world.publish([](api::Snapshot& s) { s.robots[1].initialized = false; });
  EXPECT_EQ(client.ask(joint(0)).field(), "robot");
  EXPECT_TRUE(world.commands().empty());
}

}  // namespace
}  // namespace aprsim
