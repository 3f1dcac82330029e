// One commander at a time: streams beside commands of CRCL, followed goals, tolerances, states.

#include <chrono>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/controller/stream_rig.hpp"
#include "world/api/snapshot/snapshot_fields.hpp"
#include "world/archive/archive.hpp"

namespace aprsim::robot {
namespace {

using Phase = api::StreamPhase;
using Result = api::StreamResult;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class Streams : public testing::Test {
 protected:
  void SetUp() override { rig.ready(); }
  std::vector<api::TrajectoryPoint> points(int count = 20) {
    return smooth_points(rig, engine, count, 0.05, 0.8, false);
  }
  std::string follow(api::FollowTrajectory goal, std::int64_t delay = 0) {
    goal.commander = "tester";
    return rig.send(goal, delay);
  }
  std::mt19937 engine{17};
  StreamRig rig{"fanuc"};
};

TEST_F(Streams, ASecondCommanderIsRefusedByTheNameOfTheFirst) {
  ASSERT_EQ(rig.claim(), "");
  EXPECT_EQ(rig.motion().source, api::MotionSource::kStream);
  EXPECT_EQ(rig.motion().commander, "tester");
  const std::string error = rig.send(api::ClaimMotion{"another", {}, true});
  EXPECT_TRUE(contains(error, "busy: tester has the robot")) << error;
  EXPECT_TRUE(contains(follow({.points = points()}), "busy: tester has the robot"));
  EXPECT_TRUE(contains(rig.send(api::StopStream{rig.stream + 99}), "has ended, or never began"));
  EXPECT_EQ(rig.send(api::ReleaseMotion{rig.stream}), "");
  EXPECT_EQ(rig.last_end().result, Result::kSuccessful);
  EXPECT_EQ(rig.motion().source, api::MotionSource::kNone);
  EXPECT_EQ(rig.claim(), "");
}

TEST_F(Streams, AGoneCommandersStreamIsTakenOver) {
  ASSERT_EQ(rig.claim(), "");
  const api::Ticket old = rig.stream;
  ASSERT_EQ(rig.send(api::AppendPoints{rig.stream, true, points()}), "");
  rig.steps(200);
  const std::string error = rig.send(api::ClaimMotion{"another", {}, false, old});
  EXPECT_TRUE(contains(error, "a stop is under way")) << error;
  EXPECT_EQ(rig.last_end().result, Result::kStopped);
  EXPECT_EQ(rig.last_end().text, "taken over by another");
  rig.rest();
  EXPECT_EQ(rig.send(api::ClaimMotion{"another", {}, false, old}), "");
}

TEST_F(Streams, ACommandThatMovesKeepsStreamsOut) {
  JointVector q = rig.controller().reference();
  q(0) += 0.5;
  rig.apply(move_all(q));
  rig.steps(200);
  EXPECT_EQ(rig.motion().source, api::MotionSource::kCommands);
  EXPECT_TRUE(contains(rig.claim(), "busy: a command moves the robot"));
  rig.rest();
  EXPECT_EQ(rig.claim(), "");
}

TEST_F(Streams, CommandsThatMoveAreBusyAndTheStreamGoesOn) {
  ASSERT_EQ(rig.claim(), "");
  const auto all = points();
  ASSERT_EQ(rig.send(api::AppendPoints{rig.stream, true, all}), "");
  const api::RobotAction disturbing[] = {move_all(rig.controller().reference()), api::InitRobot{},
                                         api::SetToolChanger{true}, api::MoveTo{rig.tool(), false}};
  for (const api::RobotAction& action : disturbing) {
    rig.steps(50);
    rig.apply(action);
    EXPECT_EQ(rig.state(), api::ActionState::kError);
    EXPECT_TRUE(contains(rig.reason(), "busy: tester has the robot")) << rig.reason();
    EXPECT_EQ(rig.controller().status().kind, api::kind_of(action));
    EXPECT_EQ(rig.motion().phase, Phase::kMoving);
  }
  rig.apply(api::EndRobot{});
  rig.finish();
  EXPECT_EQ(values_of(rig.controller().reference()), all.back().position_rad);
  ASSERT_EQ(rig.send(api::ReleaseMotion{rig.stream}), "");
  EXPECT_EQ(rig.run(api::InitRobot{}), api::ActionState::kDone) << rig.reason();
}

TEST_F(Streams, TheGripperWorksBesideAStream) {
  ASSERT_EQ(rig.claim(), "");
  const auto all = points();
  ASSERT_EQ(rig.send(api::AppendPoints{rig.stream, true, all}), "");
  rig.steps(100);
  EXPECT_EQ(rig.run(api::SetGripper{0}), api::ActionState::kDone) << rig.reason();
  EXPECT_EQ(rig.motion().phase, Phase::kMoving);
  rig.finish();
  EXPECT_EQ(values_of(rig.controller().reference()), all.back().position_rad);
}

TEST_F(Streams, EveryStopEndsAStream) {
  const auto stopped = [&](const std::string& text, const auto& stop) {
    ASSERT_EQ(rig.claim(api::StreamMode::kTimed, true), "") << text;
    ASSERT_EQ(rig.send(api::AppendPoints{rig.stream, true, points()}), "") << text;
    rig.steps(300);
    ASSERT_TRUE(rig.controller().moving());
    stop();
    EXPECT_EQ(rig.motion().phase, Phase::kNone) << text;
    EXPECT_EQ(rig.last_end().result, Result::kStopped) << text;
    EXPECT_TRUE(contains(rig.last_end().text, text)) << rig.last_end().text;
    EXPECT_TRUE(contains(rig.send(api::StopStream{rig.stream}), "has ended"));
    rig.rest();
    rig.steps(200);
    ASSERT_FALSE(rig.controller().moving());
  };
  for (const auto kind :
       {api::StopKind::kImmediate, api::StopKind::kFast, api::StopKind::kNormal}) {
    stopped("StopMotion", [&] { rig.apply(api::StopMotion{kind}); });
    EXPECT_EQ(rig.motion().alarm, "");
  }
  rig.steps(1500);
  stopped("curtain", [&] { rig.controller().protective_stop("curtain"); });
  EXPECT_EQ(rig.motion().alarm, "curtain");
  stopped("hit", [&] { rig.controller().protective_stop("hit", rig.controller().reference()); });
  EXPECT_EQ(rig.motion().alarm, "hit");
  stopped("fault", [&] { rig.controller().shut_down("fault", true); });
  stopped("guard", [&] { rig.controller().stop_by_guard(false, "guard"); });
}

TEST_F(Streams, AResetClearsWhatInitRobotClears) {
  rig.controller().protective_stop("curtain");
  rig.rest();
  EXPECT_TRUE(contains(rig.claim(), "alarm: curtain"));
  EXPECT_TRUE(rig.controller().stopped_by_protection());
  ASSERT_EQ(rig.claim(api::StreamMode::kTimed, true), "");
  EXPECT_FALSE(rig.controller().stopped_by_protection());
  EXPECT_TRUE(rig.controller().initialized());
  rig.send(api::ReleaseMotion{rig.stream});
  rig.controller().protective_stop("again");
  rig.rest();
  EXPECT_EQ(rig.run(api::InitRobot{}), api::ActionState::kDone);
  EXPECT_EQ(rig.claim(), "");
}

TEST_F(Streams, AStreamNeedsNoInitialisationAndWaitsForTheBrakes) {
  StreamRig fresh("motoman");
  ASSERT_EQ(fresh.claim(), "");
  ASSERT_EQ(fresh.send(api::ReleaseMotion{fresh.stream}), "");
  fresh.apply(api::StopMotion{api::StopKind::kImmediate});
  fresh.steps(10);
  EXPECT_FALSE(fresh.controller().drives_on());
  ASSERT_EQ(fresh.claim(), "");
  EXPECT_TRUE(fresh.controller().drives_on());
  const auto all = smooth_points(fresh, engine, 10, 0.05, 0.5, false);
  ASSERT_EQ(fresh.send(api::AppendPoints{fresh.stream, true, all}), "");
  fresh.steps(90);
  EXPECT_EQ(fresh.motion().time, SimTime(0)) << "the brakes release in 0.1 s";
  fresh.finish();
  EXPECT_EQ(values_of(fresh.controller().reference()), all.back().position_rad);
}

TEST_F(Streams, AReleaseWaitsForThePointsIfItShould) {
  ASSERT_EQ(rig.claim(), "");
  const auto all = points();
  ASSERT_EQ(rig.send(api::AppendPoints{rig.stream, true, all}), "");
  rig.steps(100);
  ASSERT_EQ(rig.send(api::ReleaseMotion{rig.stream, true}), "");
  EXPECT_EQ(rig.motion().phase, Phase::kMoving);
  rig.finish();
  EXPECT_EQ(rig.motion().phase, Phase::kNone);
  EXPECT_EQ(rig.last_end().result, Result::kSuccessful);
  EXPECT_EQ(values_of(rig.controller().reference()), all.back().position_rad);
}

// ---- followed trajectories

TEST_F(Streams, AGoalIsReachedAndReported) {
  const auto all = points();
  ASSERT_EQ(follow({.points = all}), "");
  const api::Ticket stream = rig.number;
  EXPECT_EQ(rig.motion().stream, stream);
  rig.finish();
  EXPECT_EQ(rig.last_end().stream, stream);
  EXPECT_EQ(rig.last_end().result, Result::kSuccessful);
  EXPECT_EQ(values_of(rig.controller().reference()), all.back().position_rad);
}

TEST_F(Streams, NamesOfJointsGiveTheOrder) {
  auto all = points();
  const auto goal = all.back().position_rad;
  std::vector<std::string> names;
  for (const Joint& joint : rig.model().joints) names.insert(names.begin(), joint.name);
  for (auto& point : all) {
    std::reverse(point.position_rad.begin(), point.position_rad.end());
    std::reverse(point.velocity_rad_s.begin(), point.velocity_rad_s.end());
  }
  ASSERT_EQ(follow({.joint_names = names, .points = all}), "");
  rig.finish();
  EXPECT_EQ(values_of(rig.controller().reference()), goal);
}

TEST_F(Streams, RefusedGoalsHaveTheResultOfRos) {
  const auto refused = [&](const api::FollowTrajectory& goal, Result result,
                           const std::string& text, std::int64_t delay = 0) {
    const JointVector here = rig.controller().reference();
    const std::string error = follow(goal, delay);
    EXPECT_TRUE(contains(error, text)) << error;
    EXPECT_EQ(rig.last_end().stream, rig.number);
    EXPECT_EQ(rig.last_end().result, result) << error;
    EXPECT_EQ(rig.last_end().text, error);
    EXPECT_EQ(rig.motion().phase, Phase::kNone);
    EXPECT_EQ(rig.motion().alarm, "") << "a goal is no alarm";
    rig.steps(20);
    EXPECT_EQ(rig.controller().reference(), here);
  };
  std::vector<std::string> names;
  for (const Joint& joint : rig.model().joints) names.push_back(joint.name);
  auto other = names;
  other[2] = "elbow";
  refused({.joint_names = other, .points = points()}, Result::kInvalidJoints, "'elbow'");
  other[2] = names[1];
  refused({.joint_names = other, .points = points()}, Result::kInvalidJoints, "named twice");
  other.resize(2);
  refused({.joint_names = other, .points = points()}, Result::kInvalidJoints, "2 of 6 joints");
  refused({.points = {}}, Result::kInvalidGoal, "no point");
  refused({.points = points()}, Result::kOldHeaderTimestamp, "has passed", -1);
  auto fast = points();
  fast[3].velocity_rad_s[4] = 100;
  refused({.points = fast}, Result::kInvalidGoal, rig.model().joints[4].name + ": speed");
  auto open = points();
  open.back().velocity_rad_s[0] = 0.1;
  refused({.points = open}, Result::kInvalidGoal, "the last point has a velocity");
  refused({.points = points(), .goal_tolerance = {{0.1, 0}}}, Result::kInvalidGoal,
          "1 tolerances, must be one for each of 6 joints");
}

TEST_F(Streams, ADelayedGoalWaitsForItsStart) {
  const JointVector here = rig.controller().reference();
  ASSERT_EQ(follow({.points = points()}, 100), "");
  EXPECT_EQ(rig.motion().phase, Phase::kMoving);
  EXPECT_EQ(rig.motion().points_left, 20u);
  rig.steps(100);
  EXPECT_EQ(rig.controller().reference(), here);
  rig.steps(1);
  EXPECT_EQ(rig.motion().time, std::chrono::milliseconds(1));
  rig.finish();
  EXPECT_EQ(rig.last_end().result, Result::kSuccessful);
}

TEST_F(Streams, ACancelledGoalStops) {
  for (const int steps : {0, 300}) {
    ASSERT_EQ(follow({.points = points()}), "");
    rig.steps(steps);
    ASSERT_EQ(rig.send(api::ReleaseMotion{rig.motion().stream}), "");
    EXPECT_EQ(rig.last_end().result, Result::kCancelled);
    rig.rest();
    EXPECT_FALSE(rig.controller().moving());
  }
}

/// Steps with an arm that is off the reference by `off` at one joint.
void step_off(StreamRig& rig, int joint, double off) {
  JointVector q = rig.controller().reference();
  q(joint) += off;
  rig.controller().step({.q_actual = q});
}

TEST_F(Streams, TolerancesEndAGoalByTheirResult) {
  const std::vector<api::JointTolerance> tight(6, {0.01, 0});
  ASSERT_EQ(follow({.points = points(), .path_tolerance = tight}), "");
  for (int k = 0; k < 300; ++k) step_off(rig, 3, 0.009);
  EXPECT_EQ(rig.motion().phase, Phase::kMoving);
  step_off(rig, 3, 0.011);
  EXPECT_EQ(rig.last_end().result, Result::kPathToleranceViolated);
  EXPECT_TRUE(contains(rig.last_end().text, rig.model().joints[3].name)) << rig.last_end().text;
  rig.rest();

  ASSERT_EQ(follow({.points = points(),
                    .goal_tolerance = tight,
                    .goal_time_tolerance = std::chrono::milliseconds(50)}),
            "");
  for (int k = 0; k < 1040; ++k) step_off(rig, 3, -0.02);
  EXPECT_EQ(rig.motion().phase, Phase::kMoving) << "within the goal's time";
  for (int k = 0; k < 20; ++k) step_off(rig, 3, -0.02);
  EXPECT_EQ(rig.last_end().result, Result::kGoalToleranceViolated);

  ASSERT_EQ(follow({.points = points(),
                    .goal_tolerance = tight,
                    .goal_time_tolerance = std::chrono::milliseconds(50)}),
            "");
  for (int k = 0; k < 1020; ++k) step_off(rig, 3, -0.02);
  step_off(rig, 3, -0.009);
  EXPECT_EQ(rig.last_end().result, Result::kSuccessful) << "in time";
}

// ---- saved states

TEST_F(Streams, ASavedStateContinuesBitForBit) {
  for (const auto mode : {api::StreamMode::kTimed, api::StreamMode::kMoves}) {
    ASSERT_EQ(rig.claim(mode), "");
    if (mode == api::StreamMode::kTimed) {
      ASSERT_EQ(rig.send(api::AppendPoints{rig.stream, true, points()}), "");
    } else {
      for (const double by : {0.6, -0.5, 0.4}) {
        JointVector q = rig.controller().reference();
        q(0) += by;
        q(1) += 0.2 * by;
        ASSERT_EQ(rig.send(api::AppendMove{rig.stream, values_of(q), 0.5, 1.0, 4}), "");
      }
    }
    for (int k = 0; k < 12; ++k) {
      rig.steps(73);
      std::string bytes;
      archive::Writer out(bytes);
      out(rig.controller().save());
      StreamRig other("fanuc");
      ControllerState state = other.controller().save();
      archive::Reader in(bytes);
      in(state);
      other.controller().restore(state);
      other.stream = rig.stream;
      for (int i = 0; i < 60; ++i) {
        StreamRig& copy = other;
        copy.step();
      }
      std::string again;
      archive::Writer write_other(again);
      write_other(other.controller().save());
      ControllerState here = rig.controller().save();
      rig.steps(60);
      std::string mine;
      archive::Writer write_mine(mine);
      write_mine(rig.controller().save());
      ASSERT_EQ(again, mine) << k;
      rig.controller().restore(here);
    }
    rig.finish();
    ASSERT_EQ(rig.send(api::ReleaseMotion{rig.stream}), "");
  }
}

}  // namespace
}  // namespace aprsim::robot
