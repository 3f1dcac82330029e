// Goals of FollowJointTrajectory: what is refused, their states, and one motion at a time.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "clients/ros2/trajectory/arm_controller.hpp"

namespace aprsim::ros2 {
namespace {

using namespace std::chrono_literals;

constexpr int kJoints = 6;

v1::RobotDescription some_robot() {
  v1::RobotDescription robot;
  robot.set_name("arm");
  for (int i = 0; i < kJoints; ++i) {
    auto& joint = *robot.add_joints();
    joint.set_name("joint_" + std::to_string(i + 1));
    joint.set_lower_rad(-2);
    joint.set_upper_rad(2);
    joint.set_max_speed_rad_s(3);
  }
  return robot;
}

google::protobuf::Duration seconds(int s) {
  google::protobuf::Duration time;
  time.set_seconds(s);
  return time;
}

/// A goal within all limits.
TrajectoryGoal some_goal(std::mt19937& random) {
  TrajectoryGoal goal;
  std::uniform_real_distribution<double> position(-2, 2);
  const auto robot = some_robot();
  for (const auto& joint : robot.joints()) goal.joint_names.push_back(joint.name());
  std::ranges::shuffle(goal.joint_names, random);
  const auto count = 1 + static_cast<int>(random() % 5);
  for (int i = 0; i < count; ++i) {
    GoalPoint point;
    for (int j = 0; j < kJoints; ++j) point.positions.push_back(position(random));
    if (random() % 2 == 0) point.velocities.assign(kJoints, i + 1 < count ? 1.0 : 0.0);
    point.time_from_start = seconds(i + 1);
    goal.points.push_back(point);
  }
  return goal;
}

TEST(Ros2Goals, EachMistakeIsRefusedWithItsField) {
  using Mistake = std::pair<std::string, void (*)(TrajectoryGoal&)>;
  const std::vector<Mistake> mistakes = {
      {"joint_names", [](auto& goal) { goal.joint_names[3] = "elbow"; }},
      {"joint_names", [](auto& goal) { goal.joint_names[3] = goal.joint_names[2]; }},
      {"joint_names", [](auto& goal) { goal.joint_names.pop_back(); }},
      {"joint_names", [](auto& goal) { goal.joint_names.clear(); }},
      {"time_from_start", [](auto& goal) { goal.points.push_back(goal.points.back()); }},
      {"time_from_start", [](auto& goal) { goal.points[0].time_from_start = seconds(-1); }},
      {"positions", [](auto& goal) { goal.points.back().positions[5] = 2.001; }},
      {"positions", [](auto& goal) { goal.points.back().positions[0] = -2.001; }},
      {"positions", [](auto& goal) { goal.points[0].positions[0] = std::nan(""); }},
      {"positions", [](auto& goal) { goal.points[0].positions.pop_back(); }},
      {"velocities", [](auto& goal) { goal.points[0].velocities.assign(kJoints, 3.1); }},
      {"velocities", [](auto& goal) { goal.points.back().velocities.assign(kJoints, 0.1); }},
      {"velocities", [](auto& goal) { goal.points[0].velocities.assign(2, 0); }},
      {"effort", [](auto& goal) { goal.points[0].effort.assign(kJoints, 0); }},
      {"multi_dof", [](auto& goal) { goal.has_multi_dof = true; }},
      {"path_tolerance", [](auto& goal) { goal.path_tolerance = {{.joint = "elbow"}}; }},
      {"goal_tolerance",
       [](auto& goal) { goal.goal_tolerance = {{.joint = "joint_1", .position = -2}}; }},
      {"goal_tolerance",
       [](auto& goal) { goal.goal_tolerance = {{.joint = "joint_1", .acceleration = 1}}; }},
      {"goal_time_tolerance", [](auto& goal) { goal.goal_time_tolerance = seconds(-2); }},
  };
  std::mt19937 random(3);
  for (int i = 0; i < 50; ++i) {
    const TrajectoryGoal goal = some_goal(random);
    ASSERT_EQ(refusal_of(goal, some_robot()), "");
    for (const auto& [field, make] : mistakes) {
      TrajectoryGoal wrong = goal;
      make(wrong);
      EXPECT_NE(refusal_of(wrong, some_robot()).find(field), std::string::npos)
          << field << ": " << refusal_of(wrong, some_robot());
    }
  }
}

TEST(Ros2Goals, TolerancesFollowTheOrderOfTheGoalAndTheControllersDefaults) {
  std::mt19937 random(4);
  for (int i = 0; i < 50; ++i) {
    TrajectoryGoal goal = some_goal(random);
    goal.path_tolerance = {{.joint = "joint_4", .position = 0.5, .velocity = 0.25}};
    goal.goal_tolerance = {{.joint = "joint_2", .position = 0.1, .velocity = -1}};
    const auto request = request_of(goal, some_robot(), 20);
    const auto& trajectory = request.trajectory();
    ASSERT_EQ(trajectory.path_tolerance_size(), kJoints);
    ASSERT_EQ(trajectory.goal_tolerance_size(), kJoints);
    for (int joint = 0; joint < kJoints; ++joint) {
      const auto& name = trajectory.joint_names(joint);
      EXPECT_EQ(trajectory.path_tolerance(joint).position_rad(), name == "joint_4" ? 0.5 : 0);
      EXPECT_EQ(trajectory.path_tolerance(joint).velocity_rad_s(), name == "joint_4" ? 0.25 : 0);
      EXPECT_EQ(trajectory.goal_tolerance(joint).position_rad(), name == "joint_2" ? 0.1 : 0);
      EXPECT_EQ(trajectory.goal_tolerance(joint).velocity_rad_s(), name == "joint_2" ? 0 : 0.01);
    }
    EXPECT_EQ(trajectory.points_size(), static_cast<int>(goal.points.size()));
    EXPECT_FALSE(trajectory.has_start());
    EXPECT_EQ(request.feedback_period().nanos(), 50'000'000);
  }
}

GoalId id_of(int number) {
  GoalId id{};
  id[0] = static_cast<std::uint8_t>(number + 1);
  return id;
}

TEST(Ros2Goals, CancellingFollowsTheRulesOfTheActionProtocol) {
  GoalTable table;
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(table.add(id_of(i), seconds(i + 1)));
    EXPECT_FALSE(table.add(id_of(i), seconds(9)));
  }
  table.end(id_of(0), GoalState::kSucceeded, {}, {});
  EXPECT_EQ(table.cancel(id_of(0), {}).return_code, 3);
  EXPECT_EQ(table.cancel(id_of(8), {}).return_code, 2);
  const auto until = table.cancel({}, seconds(2));  // accepted until then
  ASSERT_EQ(until.goals.size(), 1U);
  EXPECT_EQ(until.goals[0].id, id_of(1));
  const auto one = table.cancel(id_of(3), {});
  ASSERT_EQ(one.goals.size(), 1U);
  EXPECT_EQ(one.goals[0].id, id_of(3));
  EXPECT_EQ(table.cancel(id_of(3), {}).return_code, 3);  // is being cancelled
  const auto all = table.cancel({}, {});
  ASSERT_EQ(all.goals.size(), 1U);
  EXPECT_EQ(all.goals[0].id, id_of(2));
  EXPECT_TRUE(table.cancel({}, {}).goals.empty());
  // Ended goals go, others stay.
  EXPECT_FALSE(table.expire(std::chrono::steady_clock::time_point(59s)));
  EXPECT_TRUE(table.expire(std::chrono::steady_clock::time_point(60s)));
  EXPECT_EQ(table.goals().size(), 3U);
}

TEST(Ros2Goals, EndedGoalsAreBoundedInNumber) {
  GoalTable table;
  for (int i = 0; i < 250; ++i) {
    table.add(id_of(i), seconds(1));
    if (i != 100) table.end(id_of(i), GoalState::kAborted, {}, {});
  }
  table.expire({});
  EXPECT_EQ(table.goals().size(), GoalTable::kMostEnded + 1);
  EXPECT_NE(table.find(id_of(100)), nullptr);
  EXPECT_NE(table.find(id_of(249)), nullptr);
}

/// Motions that end when the test says so.
struct Motions {
  struct Call final : MotionCall {
    explicit Call(Motions& in) : motions(in) { ++motions.under_way; }
    ~Call() override { --motions.under_way; }
    void cancel() override { motions.is_cancelled = true; }
    Motions& motions;
  };
  std::unique_ptr<MotionCall> start(std::uint64_t number) {
    EXPECT_EQ(under_way, 0) << "two motions at a time";
    call = number;
    is_cancelled = false;
    return std::make_unique<Call>(*this);
  }
  int under_way = 0;
  std::uint64_t call = 0;
  bool is_cancelled = false;
};

TEST(Ros2Goals, OneMotionAtATimeAndEachGoalEndsOnceForRandomClients) {
  std::mt19937 random(5);
  for (int round = 0; round < 100; ++round) {
    Motions motions;
    ArmController arm(some_robot(),
                      [&](std::uint64_t call, const auto&) { return motions.start(call); });
    std::map<GoalId, GoalState> ended;
    int last = -1;
    for (int i = 0; i < 60; ++i) {
      if (random() % 3 == 0) {
        ASSERT_EQ(arm.accept(id_of(++last), some_goal(random), seconds(i)), "");
      } else if (random() % 3 == 0 && last >= 0) {
        const auto some = static_cast<int>(random() % static_cast<unsigned>(last + 1));
        EXPECT_LE(arm.cancel(id_of(some), {}).goals.size(), 1U);
      } else if (motions.under_way == 1) {
        const bool succeeds = !motions.is_cancelled || random() % 4 == 0;
        arm.handle(motions.call, {.succeeded = succeeds, .cancelled = !succeeds, .result = {}});
      }
      int open = 0;
      for (const auto& goal : arm.goals().goals()) {
        if (const auto before = ended.find(goal.id); before != ended.end()) {
          EXPECT_EQ(before->second, goal.state);
        }
        if (has_ended(goal.state)) {
          ended[goal.id] = goal.state;
        } else {
          ++open;
          // Only the latest goal, and one that is being cancelled, are open.
          EXPECT_TRUE(goal.id == id_of(last) || goal.state == GoalState::kCanceling);
        }
      }
      EXPECT_LE(open, 2);
    }
    while (motions.under_way == 1) {
      arm.handle(motions.call, {.succeeded = true, .cancelled = false, .result = {}});
    }
    for (const auto& goal : arm.goals().goals()) EXPECT_TRUE(has_ended(goal.state));
  }
}

}  // namespace
}  // namespace aprsim::ros2
