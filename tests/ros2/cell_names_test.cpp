// The names and frames that aprsim-ros2 publishes.

#include <map>
#include <random>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "clients/ros2/cell/frames.hpp"
#include "clients/ros2/cell/joint_states.hpp"
#include "clients/ros2/cell/names.hpp"

namespace aprsim::ros2 {
namespace {

TEST(Ros2Names, TokensHaveRosCharactersOnly) {
  EXPECT_EQ(ros_token("fanuc"), "fanuc");
  EXPECT_EQ(ros_token("large gear-3"), "large_gear_3");
  EXPECT_EQ(ros_token("3rd"), "_3rd");
}

TEST(Ros2Names, JointNamesAreUniqueForRandomRobots) {
  std::mt19937 random(7);
  for (int i = 0; i < 200; ++i) {
    v1::CellDescription cell;
    std::map<std::string, int> uses;
    for (int robot = 0; robot < 3; ++robot) {
      auto& arm = *cell.add_robots();
      arm.set_name("arm" + std::to_string(robot));
      for (int joint = 0; joint < 6; ++joint) {
        const bool shared = random() % 2 == 0;
        arm.add_joints()->set_name((shared ? "j" : "j" + arm.name()) + std::to_string(joint));
        ++uses[arm.joints(joint).name()];
      }
    }
    std::set<std::string> seen;
    const auto names = joint_names(cell);
    for (std::size_t robot = 0; robot < names.size(); ++robot) {
      for (std::size_t joint = 0; joint < names[robot].size(); ++joint) {
        const auto& arm = cell.robots(static_cast<int>(robot));
        const std::string own = arm.joints(static_cast<int>(joint)).name();
        const auto& name = names[robot][joint];
        EXPECT_TRUE(seen.insert(name).second) << name;
        EXPECT_EQ(name, uses[own] > 1 ? arm.name() + "_" + own : own);
      }
    }
  }
}

TEST(Ros2Names, JointStatesKeepOrderAndValues) {
  v1::RobotState robot;
  for (int i = 0; i < 3; ++i) {
    auto& joint = *robot.add_joints();
    joint.set_position_rad(i);
    joint.set_velocity_rad_s(10 + i);
    joint.set_torque_nm(20 + i);
  }
  JointStates states;
  append_joints(states, robot, {"a", "b", "c"});
  EXPECT_EQ(states.name, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(states.position, (std::vector<double>{0, 1, 2}));
  EXPECT_EQ(states.velocity, (std::vector<double>{10, 11, 12}));
  EXPECT_EQ(states.effort, (std::vector<double>{20, 21, 22}));
}

TEST(Ros2Names, LostBodiesHaveNoFrame) {
  v1::Snapshot snapshot;
  snapshot.add_bodies()->set_name("gear 1");
  auto& lost = *snapshot.add_bodies();
  lost.set_name("gear 2");
  lost.set_lost_step(5);
  const auto frames = moving_frames({}, snapshot);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames.front().name, "gear_1");
}

}  // namespace
}  // namespace aprsim::ros2
