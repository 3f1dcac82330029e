// Moves begin a fixed simulated time after their command, whoever plans them and whenever.

#include <random>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/controller/controller_rig.hpp"
#include "world/robot/planning/plan_job.hpp"

namespace aprsim::robot {
namespace {

using api::ActionState;

constexpr int kBase = 8, kWaypoint = 2, kScrew = 30, kSearch = 50;  // steps of 1 ms

/// Makes no plan, but counts what it is asked for.
class Counter : public PlanPrefetcher {
 public:
  void prefetch(std::shared_ptr<PlanJob>) override { ++jobs; }
  int jobs = 0;
};

ControllerSetup with_latency(const std::string& arm, PlanPrefetcher* prefetcher = nullptr) {
  ControllerSetup setup = rig_setup(arm);
  setup.latency = {kBase * 1e-3, kWaypoint * 1e-3, kScrew * 1e-3, kSearch * 1e-3};
  setup.prefetcher = prefetcher;
  return setup;
}

TEST(PlanningSteps, AreMoreForChecksAndWaysRound) {
  const PlanningLatency latency{.base_s = 8e-3, .search_s = 0.25, .check_s = 12e-3, .avoid_s = 0.1};
  const PlannedMove free = api::MoveTo{}, line = api::MoveTo{.straight = true};
  const PlannedMove joints = api::MoveJoints{};
  using api::PlanningMode;
  const auto steps = [&](const PlannedMove& move, bool search, PlanningMode mode) {
    return planning_steps(latency, 1e-3, move, search, mode);
  };
  EXPECT_EQ(steps(free, false, PlanningMode::kDirect), 8);
  EXPECT_EQ(steps(free, false, PlanningMode::kCheck), 20);
  EXPECT_EQ(steps(free, true, PlanningMode::kAvoid), 120);
  EXPECT_EQ(steps(joints, true, PlanningMode::kAvoid), 120);
  EXPECT_EQ(steps(line, true, PlanningMode::kAvoid), 270);
  EXPECT_EQ(steps(line, true, PlanningMode::kDirect), 258);
}

class Latency : public testing::TestWithParam<const char*> {
 protected:
  Latency() : rig(with_latency(GetParam(), &counter)) { rig.ready(); }

  api::MoveTo shifted(double x, double y, double z, bool straight) const {
    Pose X = rig.tool();
    X.p += Eigen::Vector3d(x, y, z);
    return {X, straight};
  }
  /// Steps until the reference moves.
  int delay() {
    const JointVector before = rig.controller().reference();
    for (int i = 0; i < 1000; ++i) {
      rig.step();
      if (rig.controller().reference() != before) return i;
    }
    return -1;
  }

  Counter counter;
  ControllerRig rig;
};
INSTANTIATE_TEST_SUITE_P(Arms, Latency, testing::Values("fanuc", "motoman"),
                         [](const auto& arm) { return std::string(arm.param); });

TEST_P(Latency, IsThatOfTheKindOfMove) {
  rig.apply(shifted(0, 0, 0.05, true));
  EXPECT_EQ(rig.state(), ActionState::kWorking);
  EXPECT_TRUE(rig.controller().moving());
  EXPECT_EQ(delay(), kBase);
  rig.rest();
  rig.apply(shifted(0, 0, -0.05, false));
  EXPECT_EQ(delay(), kBase);
  rig.rest();
  rig.apply(api::MoveJoints{{{.joint = 0, .position_rad = 0}}});
  EXPECT_EQ(delay(), kBase);
  rig.rest();
  const api::Waypoint up{shifted(0, 0, 0.01, true).X_RT}, back{rig.tool()};
  rig.apply(api::MoveThroughTo{{up, back, up}, true});
  EXPECT_EQ(delay(), kBase + 3 * kWaypoint);
  rig.rest();
  rig.apply(api::MoveScrew{.screw_m = 0.01, .turn_rad = 0.1});
  EXPECT_EQ(delay(), kBase + kScrew);
  rig.rest();
  EXPECT_EQ(rig.state(), ActionState::kDone) << rig.reason();
}

TEST_P(Latency, PlansOnlyTheLastOfMovesInQuickSuccession) {
  rig.apply(shifted(0, 0, 0.01, false));
  rig.step();
  counter.jobs = 0;
  for (int i = 2; i <= 6; ++i) {
    rig.apply(shifted(0, 0, 0.01 * i, i % 2 == 0));
    rig.step();
  }
  const Pose last = shifted(0, 0, 0.07, false).X_RT;
  rig.apply(api::MoveTo{last, false});
  EXPECT_EQ(counter.jobs, 0);
  rig.rest();
  EXPECT_EQ(counter.jobs, 1);
  EXPECT_EQ(rig.state(), ActionState::kDone) << rig.reason();
  EXPECT_LT((rig.tool().p - last.p).norm(), 1e-9);
}

TEST_P(Latency, AStreamOfMovesMovesTheArm) {
  const JointVector before = rig.controller().reference();
  const Pose goal = shifted(0, 0, 0.1, false).X_RT;
  for (int i = 0; i < 2000; ++i) {
    rig.apply(api::MoveTo{goal, false});
    rig.step();
  }
  EXPECT_NE(rig.controller().reference(), before);
  EXPECT_LT((rig.tool().p - goal.p).norm(), 1e-6);
  EXPECT_LE(rig.effort().accel, 1.05);
}

/// Straight lines of the seven-axis arm from anywhere to anywhere.
class RandomLines {
 public:
  /// The arm, ready at the start of the next line.
  ControllerRig next() {
    ControllerSetup setup = with_latency("motoman");
    setup.q_home = ControllerRig("motoman").random_posture(engine_, 0.05);
    ControllerRig rig(std::move(setup));
    rig.run(api::InitRobot{});
    goal_ = rig.tool();
    goal_.p += Eigen::Vector3d(shift_(engine_), shift_(engine_), shift_(engine_));
    return rig;
  }
  [[nodiscard]] api::MoveTo move() const { return {goal_, true}; }

 private:
  std::mt19937 engine_{5};
  std::uniform_real_distribution<double> shift_{-0.3, 0.3};
  Pose goal_;
};

/// Steps until the arm moves or refuses to.
int planning_time(ControllerRig& rig, const api::MoveTo& move) {
  const JointVector before = rig.controller().reference();
  rig.apply(move);
  int steps = 0;
  while (rig.controller().reference() == before && rig.state() == ActionState::kWorking) {
    rig.step();
    if (++steps == 1000) break;
  }
  return steps;
}

constexpr int kSearched = 2 * kBase + kSearch + 1;

TEST(SearchLatency, ComesOnTopWhereALineNeedsOtherPostures) {
  RandomLines lines;
  int moved = 0, searched = 0;
  for (int i = 0; i < 200; ++i) {
    ControllerRig rig = lines.next();
    const int steps = planning_time(rig, lines.move());
    EXPECT_TRUE(steps == kBase + 1 || steps == kSearched) << steps;
    if (rig.state() == ActionState::kError) continue;
    ++moved;
    searched += steps == kSearched;
    if (steps == kBase + 1) continue;
    rig.rest(120);
    EXPECT_EQ(rig.state(), ActionState::kDone) << rig.reason();
    EXPECT_LT((rig.tool().p - lines.move().X_RT.p).norm(), 1e-9);
  }
  EXPECT_GT(moved, 50);
  EXPECT_GT(searched, 3);
}

TEST(SearchLatency, EndsWithAStopAndIsNotBegunAnewByLaterMoves) {
  RandomLines lines;
  int tried = 0;
  for (int i = 0; i < 200 && tried < 3; ++i) {
    ControllerRig rig = lines.next();
    const JointVector before = rig.controller().reference();
    ControllerRig other(rig.setup());
    other.run(api::InitRobot{});
    if (planning_time(other, lines.move()) != kSearched) continue;
    if (other.state() == ActionState::kError) continue;
    ++tried;
    rig.apply(lines.move());
    rig.steps(kBase + kSearch / 2);
    rig.apply(api::StopMotion{api::StopKind::kNormal});
    rig.steps(300);
    EXPECT_EQ(rig.controller().reference(), before);
    EXPECT_EQ(rig.state(), ActionState::kDone) << rig.reason();
    for (int k = 0; k < 500; ++k) {
      rig.apply(lines.move());
      rig.step();
    }
    EXPECT_NE(rig.controller().reference(), before) << rig.reason();
  }
  EXPECT_EQ(tried, 3);
}

TEST_P(Latency, AShortPlanDoesNotWaitForALongOne) {
  std::vector<api::Waypoint> points;
  for (int i = 0; i < 300; ++i) points.push_back({shifted(0, 0, 1e-4 * i, true).X_RT});
  rig.apply(api::MoveThroughTo{points, true});
  rig.steps(5);
  rig.apply(shifted(0, 0.03, 0, true));
  EXPECT_EQ(delay(), kBase);
  rig.rest();
  EXPECT_EQ(rig.state(), ActionState::kDone);
}

TEST_P(Latency, WhateverStopsTheArmEndsThePlanToo) {
  const JointVector before = rig.controller().reference();
  const std::vector<api::RobotAction> others{
      api::StopMotion{api::StopKind::kNormal}, api::StopMotion{api::StopKind::kFast},
      api::StopMotion{api::StopKind::kImmediate}, api::InitRobot{}};
  for (const api::RobotAction& other : others) {
    for (const int steps : {0, 3, kBase}) {
      rig.apply(shifted(0, 0, 0.05, steps > 0));
      rig.steps(steps);
      rig.apply(other);
      rig.rest();
      rig.steps(100);
      EXPECT_EQ(rig.controller().reference(), before) << other.index();
      EXPECT_EQ(rig.state(), ActionState::kDone) << rig.reason();
    }
  }
}

TEST_P(Latency, GripperAndDwellNeitherEndNorDelayAPlan) {
  const Pose goal = shifted(0, 0, 0.05, true).X_RT;
  rig.apply(api::MoveTo{goal, true});
  rig.steps(3);
  rig.apply(api::SetGripper{0});
  rig.apply(api::Dwell{std::chrono::milliseconds(5)});
  EXPECT_EQ(delay(), kBase - 3);
  rig.rest();
  EXPECT_LT((rig.tool().p - goal.p).norm(), 1e-9);
  EXPECT_EQ(rig.state(), ActionState::kDone) << rig.reason();
}

TEST_P(Latency, TheErrorOfAMoveShowsWithTheDwellBesideIt) {
  rig.apply(shifted(30, 0, 0, false));
  rig.steps(3);
  rig.apply(api::Dwell{std::chrono::seconds(1)});
  rig.steps(kBase);
  EXPECT_EQ(rig.state(), ActionState::kError);
  EXPECT_EQ(rig.controller().status().ticket, rig.ticket());
  EXPECT_EQ(rig.reason().find("the move before: "), 0U) << rig.reason();
}

TEST_P(Latency, SettingsNeitherEndNorDelayAPlan) {
  rig.apply(shifted(0, 0, 0.05, true));
  rig.steps(3);
  rig.apply(api::SetMotionLimit{api::MotionLimit::kTransSpeed, true, 0.5});
  rig.apply(api::SetOverride{0.5});
  EXPECT_EQ(delay(), kBase - 3);
}

TEST_P(Latency, AMoveThatCannotBePlannedIsRefusedWhenItWouldBegin) {
  rig.apply(shifted(30, 0, 0, false));
  rig.steps(kBase);
  EXPECT_EQ(rig.state(), ActionState::kWorking);
  rig.step();
  EXPECT_EQ(rig.state(), ActionState::kError);
  EXPECT_NE(rig.reason().find("reach"), std::string::npos) << rig.reason();
  // The error of a move that has been replaced is nobody's.
  rig.run(api::InitRobot{});
  rig.apply(shifted(30, 0, 0, false));
  rig.steps(3);
  EXPECT_EQ(rig.run(shifted(0, 0, 0.02, false)), ActionState::kDone) << rig.reason();
}

/// The same commands at the same steps, with plans made by a thread, by the stepping thread, and by
/// both in controllers that take over from each other: the same bits.
TEST_P(Latency, IsTheSameForEveryPlanner) {
  PlanningThread thread;
  const auto play = [&](PlanPrefetcher* prefetcher, bool handed_over) {
    ControllerRig robot(with_latency(GetParam(), prefetcher));
    robot.ready();
    ControllerRig other(with_latency(GetParam(), prefetcher));
    std::mt19937 engine(41);
    std::uniform_int_distribution<int> pause(0, 300), some(0, 3);
    std::vector<JointVector> path;
    ControllerRig* now = &robot;
    ControllerRig* next = &other;
    for (int n = 0; n < 300; ++n) {
      now->apply(now->state() == ActionState::kError ? api::RobotAction(api::InitRobot{})
                                                     : now->random_command(engine));
      if (some(engine) == 0) now->apply(api::SetOverride{0.25 * (1 + some(engine))});
      const int steps = some(engine) == 0 ? pause(engine) / 30 : pause(engine);
      for (int i = 0; i < steps; ++i) {
        now->step();
        path.push_back(now->controller().reference());
      }
      if (!handed_over) continue;
      next->controller().restore(now->controller().save());
      std::swap(now, next);
    }
    return path;
  };
  const auto expected = play(nullptr, false);
  EXPECT_EQ(play(&thread, false), expected);
  EXPECT_EQ(play(nullptr, true), expected);
  EXPECT_EQ(play(&thread, true), expected);
}

/// As SteadyState's, with commands that come while others are being planned.
TEST_P(Latency, AnyCommandsAtAnyTimeKeepTheJointsWithinTheirLimits) {
  std::mt19937 engine(43);
  std::uniform_int_distribution<int> pause(0, 60);
  rig.forget();
  for (int n = 0; n < 1500; ++n) {
    rig.apply(rig.state() == ActionState::kError ? api::RobotAction(api::InitRobot{})
                                                 : rig.random_command(engine));
    rig.steps(n % 3 == 0 ? 10 * pause(engine) : pause(engine) / 6);
  }
  rig.rest();
  EXPECT_FALSE(rig.controller().moving());
  for (const JointVector& q : rig.path()) {
    ASSERT_TRUE((q.array() >= rig.limits().lower.array()).all());
    ASSERT_TRUE((q.array() <= rig.limits().upper.array()).all());
  }
  const auto effort = rig.effort();
  EXPECT_LE(effort.speed, 1.01);
  EXPECT_LE(effort.accel, 1.1);
}

}  // namespace
}  // namespace aprsim::robot
