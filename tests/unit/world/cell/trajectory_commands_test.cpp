// Streams of joint motions in the whole cell: the servo follows, what stops a robot ends them, a
// saved state continues them.

#include <chrono>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"
#include "world/cell/state_bytes.hpp"

namespace aprsim::test {
namespace {

using Result = api::StreamResult;
using std::chrono::milliseconds;

constexpr int kFanuc = 0, kMotoman = 1;

class TrajectoryCommands : public testing::Test {
 protected:
  explicit TrajectoryCommands(const std::string& scene = "aprs") : cell(load_scene(scene)) {}

  std::string send(int robot, const api::TrajectoryAction& action) {
    const auto done = cell.world.apply(++ticket, api::TrajectoryCommand{robot, action});
    cell.world.write(cell.now);
    return done ? "" : done.error().message;
  }
  const api::RobotSnapshot& robot(int index) {
    return cell.now.robots[static_cast<std::size_t>(index)];
  }
  api::StreamEnd last_end(int index) { return robot(index).motion.ends->back(); }

  /// A swing of joint 0 by `by` [rad] and back.
  api::FollowTrajectory swing(int index, double by, double seconds = 2) {
    const std::size_t joints =
        cell.world.description()->robots[static_cast<std::size_t>(index)].joints.size();
    api::FollowTrajectory goal{.commander = "tester"};
    constexpr int kPoints = 40;
    for (int k = 0; k <= kPoints; ++k) {
      const double t = seconds * k / kPoints, w = 2 * M_PI / seconds;
      api::TrajectoryPoint point{SimTime(static_cast<SimTime::rep>(std::llround(t * 1e9)))};
      for (std::size_t i = 0; i < joints; ++i) {
        const double share = i == 0 ? by / 2 : 0;
        const double home = robot(index).motion.reference_rad[i];
        point.position_rad.push_back(home + share * (1 - std::cos(w * t)));
        point.velocity_rad_s.push_back(k == kPoints ? 0 : share * w * std::sin(w * t));
      }
      goal.points.push_back(point);
    }
    return goal;
  }

  CellScript cell;
  api::Ticket ticket = 100;
};

TEST_F(TrajectoryCommands, TheArmsFollowWithoutACrclSession) {
  for (const int index : {kFanuc, kMotoman}) {
    ASSERT_FALSE(robot(index).initialized);
    const double home = robot(index).joints[0].position_rad;
    ASSERT_EQ(send(index, swing(index, 0.4)), "");
    EXPECT_EQ(robot(index).motion.source, api::MotionSource::kStream);
    const api::Ticket before = robot(index).action.ticket;
    double farthest = 0;
    for (int step = 0; step < 2100; ++step) {
      cell.advance();
      farthest = std::max(farthest, robot(index).joints[0].position_rad - home);
      ASSERT_EQ(robot(index).joints[0].position_rad, robot(index).motion.reference_rad[0]);
    }
    EXPECT_NEAR(farthest, 0.4, 1e-6);
    EXPECT_EQ(last_end(index).result, Result::kSuccessful) << last_end(index).text;
    EXPECT_EQ(robot(index).motion.source, api::MotionSource::kNone);
    EXPECT_EQ(robot(index).action.ticket, before) << "CRCL's latest command is not concerned";
    EXPECT_NEAR(robot(index).joints[0].position_rad, home, 1e-12);
  }
}

TEST_F(TrajectoryCommands, ACommandOfCrclIsBusyMeanwhile) {
  ASSERT_EQ(send(kFanuc, swing(kFanuc, 0.4)), "");
  cell.advance(100);
  EXPECT_THROW(cell.act(kFanuc, api::InitRobot{}), std::runtime_error);
  EXPECT_EQ(robot(kFanuc).action.state, api::ActionState::kError);
  EXPECT_NE(robot(kFanuc).action.description.find("busy: tester has the robot"), std::string::npos);
  EXPECT_EQ(robot(kFanuc).motion.phase, api::StreamPhase::kMoving);
  cell.act(kMotoman, api::InitRobot{});
  cell.advance(2000);
  EXPECT_EQ(last_end(kFanuc).result, Result::kSuccessful);
  cell.act(kFanuc, api::InitRobot{});
}

TEST_F(TrajectoryCommands, GuardsOfABusyCommandDoNotStopTheStream) {
  ASSERT_EQ(send(kFanuc, swing(kFanuc, 0.4)), "");
  cell.advance(100);
  const api::Guard at_once{
      .signal = {api::SignalKind::kForceR, 2, false}, .value = -1e6, .label = "g"};
  EXPECT_THROW(cell.act(kFanuc, api::MoveJoints{{{.joint = 0, .position_rad = 1}}}, 1, {at_once}),
               std::runtime_error);
  cell.advance(2000);
  EXPECT_EQ(last_end(kFanuc).result, Result::kSuccessful) << last_end(kFanuc).text;
}

TEST_F(TrajectoryCommands, StopMotionEndsTheStream) {
  ASSERT_EQ(send(kMotoman, swing(kMotoman, 0.4)), "");
  cell.advance(500);
  cell.act(kMotoman, api::StopMotion{});
  EXPECT_EQ(last_end(kMotoman).result, Result::kStopped);
  EXPECT_EQ(last_end(kMotoman).text, "stopped by StopMotion");
  EXPECT_FALSE(robot(kMotoman).moving);
  EXPECT_EQ(robot(kMotoman).motion.alarm, "");
}

TEST_F(TrajectoryCommands, AStartInThePastIsRefusedAndOneInTheFutureWaits) {
  cell.advance(100);
  auto goal = swing(kFanuc, 0.1);
  goal.start = milliseconds(99);
  EXPECT_NE(send(kFanuc, goal), "");
  EXPECT_EQ(last_end(kFanuc).result, Result::kOldHeaderTimestamp);
  goal.start = milliseconds(150);
  ASSERT_EQ(send(kFanuc, goal), "");
  cell.advance(50);
  EXPECT_EQ(robot(kFanuc).motion.time, SimTime(0));
  cell.advance(1);
  EXPECT_EQ(cell.world.time(), milliseconds(151));
  EXPECT_EQ(robot(kFanuc).motion.time, milliseconds(1));
}

TEST_F(TrajectoryCommands, AnInjectedStopEndsTheStreamAndIsAnAlarm) {
  for (const char* kind : {"robot-emergency-stop", "robot-breakdown", "protective-stop"}) {
    cell.world = world::World(load_scene("aprs"), 1);
    cell.world.write(cell.now);
    ASSERT_EQ(send(kFanuc, swing(kFanuc, 0.4)), "") << kind;
    cell.advance(300);
    const api::InjectFault fault{
        .kind = kind, .target = "fanuc", .parameters = {}, .trigger = {}, .duration = {}};
    const auto injected = cell.world.apply(++ticket, api::FaultCommand(fault));
    ASSERT_TRUE(injected) << injected.error().message;
    cell.advance(600);
    EXPECT_EQ(last_end(kFanuc).result, Result::kStopped) << kind;
    EXPECT_EQ(robot(kFanuc).motion.alarm, last_end(kFanuc).text) << kind;
    EXPECT_NE(send(kFanuc, swing(kFanuc, 0.1)).find("alarm: "), std::string::npos) << kind;
  }
}

TEST_F(TrajectoryCommands, ATouchStopsAndAResetGoesOn) {
  scene::Scene scene = *load_scene("aprs");
  const auto& base = scene.robots[kFanuc].X_WB;
  Pose X_WS;
  X_WS.p = base.p + base.q * Eigen::Vector3d(0.35 * std::cos(0.6), 0.35 * std::sin(0.6), 0.69);
  scene.fixed.push_back({"post", {0.05, 0.05, 0.3}, X_WS});
  cell.world = world::World(std::make_shared<const scene::Scene>(std::move(scene)), 1);
  cell.world.write(cell.now);
  ASSERT_EQ(send(kFanuc, swing(kFanuc, 2, 6)), "");
  for (int step = 0; step < 4000 && !robot(kFanuc).protective_stop; ++step) cell.advance();
  ASSERT_TRUE(robot(kFanuc).protective_stop);
  EXPECT_EQ(last_end(kFanuc).result, Result::kStopped);
  EXPECT_NE(last_end(kFanuc).text.find("touches post"), std::string::npos) << last_end(kFanuc).text;
  EXPECT_EQ(robot(kFanuc).motion.alarm, last_end(kFanuc).text);
  auto back = swing(kFanuc, -0.1);
  back.reset = true;
  EXPECT_NE(send(kFanuc, back), "") << "it still retreats";
  cell.advance(3000);
  back = swing(kFanuc, -0.1);
  back.reset = true;
  ASSERT_EQ(send(kFanuc, back), "");
  EXPECT_FALSE(robot(kFanuc).protective_stop);
  cell.advance(2500);
  EXPECT_EQ(last_end(kFanuc).result, Result::kSuccessful) << last_end(kFanuc).text;
}

TEST_F(TrajectoryCommands, TheLightCurtainStopsAStream) {
  scene::Scene scene = *load_scene("aprs");
  scene.light_curtain->reaction = api::CurtainReaction::kAll;
  cell.world = world::World(std::make_shared<const scene::Scene>(std::move(scene)), 1);
  cell.world.write(cell.now);
  ASSERT_EQ(send(kMotoman, swing(kMotoman, 0.4)), "");
  cell.advance(300);
  api::Intruder person;
  person.X_WI.p = {0, -1.75, 0.9};
  person.size_m = {0.5, 0.3, 1.8};
  cell.world.apply(++ticket, api::SetIntruder{person});
  cell.advance(1);
  EXPECT_EQ(last_end(kMotoman).result, Result::kStopped);
  EXPECT_NE(robot(kMotoman).motion.alarm.find("light curtain"), std::string::npos);
  cell.advance(1000);
  // A reset while it is broken stops again at once.
  api::ClaimMotion claim{"tester", api::StreamMode::kTimed, true};
  send(kMotoman, claim);
  EXPECT_EQ(robot(kMotoman).motion.stream, 0U);
  EXPECT_NE(robot(kMotoman).motion.alarm, "");
}

TEST_F(TrajectoryCommands, ASavedStateContinuesElsewhereBitForBit) {
  ASSERT_EQ(send(kMotoman, swing(kMotoman, 0.5)), "");
  ASSERT_EQ(send(kFanuc, api::ClaimMotion{"moves", api::StreamMode::kMoves}), "");
  const api::Ticket moves = ticket;
  for (const double q0 : {0.4, -0.2}) {
    std::vector<double> q(6, 0.0);
    q[0] = q0;
    q[4] = -1.2;
    ASSERT_EQ(send(kFanuc, api::AppendMove{moves, q, 0.3, 0.5, 4}), "");
  }
  cell.advance(321);
  const world::WorldState saved = cell.world.save();
  const std::string bytes = world::to_bytes(saved);
  world::World other(load_scene("aprs"), 2);
  const auto read = world::from_bytes(bytes, other.save());
  ASSERT_TRUE(read) << read.error().message;
  other.restore(*read);
  EXPECT_EQ(world::to_bytes(other.save()), bytes);
  for (int i = 0; i < 2500; ++i) {
    cell.world.step();
    other.step();
    ASSERT_EQ(cell.world.state_hash(), other.state_hash()) << i;
  }
  EXPECT_EQ(world::to_bytes(other.save()), world::to_bytes(cell.world.save()));
  cell.world.write(cell.now);
  EXPECT_EQ(last_end(kMotoman).result, Result::kSuccessful);
  EXPECT_EQ(robot(kFanuc).motion.points_done, 2U);
}

}  // namespace
}  // namespace aprsim::test
