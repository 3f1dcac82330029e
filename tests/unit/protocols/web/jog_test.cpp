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
  EXPECT_DOUBLE_EQ(*move.targets[0].speed_rad_s, 1.0);
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
  ASSERT_GE(world.commands().size(), 3u);
  EXPECT_TRUE(std::holds_alternative<api::StopMotion>(action(1)));
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
  EXPECT_NE(again.message().find("taken the robot over"), std::string::npos) << again.message();
  EXPECT_TRUE(client.ask(release()).ok());
  EXPECT_EQ(world.commands().size(), 1u);
  EXPECT_TRUE(client.ask(joint(0)).ok()) << "pressed anew";
}

TEST_F(Jog, ToolStretchesShrinkWhileTheRobotRefusesThem) {
  RawWebClient client(port);
  (void)client.upgrade();
  ASSERT_TRUE(client.ask(along_x()).ok());
  // A limit, the stretch, the limit as it was.
  ASSERT_EQ(world.commands().size(), 3u);
  EXPECT_TRUE(std::holds_alternative<api::SetMotionLimit>(action(0)));
  EXPECT_TRUE(std::holds_alternative<api::SetMotionLimit>(action(2)));
  const double first = std::get<api::MoveTo>(action(1)).X_RT.p.x();
  EXPECT_TRUE(std::get<api::MoveTo>(action(1)).straight);
  world.report(1, 3, api::ActionState::kError, "out of reach");
  ASSERT_TRUE(world.wait_for_commands(7));
  EXPECT_TRUE(std::holds_alternative<api::InitRobot>(action(3)));
  EXPECT_DOUBLE_EQ(std::get<api::MoveTo>(action(5)).X_RT.p.x(), first / 2);
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
  request.mutable_jog()->set_robot(9);
  EXPECT_EQ(client.ask(request).field(), "robot");
  world.publish([](api::Snapshot& s) { s.robots[1].initialized = false; });
  EXPECT_EQ(client.ask(joint(0)).field(), "robot");
  EXPECT_TRUE(world.commands().empty());
}

}  // namespace
}  // namespace aprsim
