// The arithmetic between a robot's joints as CRCL counts them and the arm's own.

#include "protocols/crcl/joint_map.hpp"

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

namespace aprsim::crcl_server {
namespace {

using crcl::AngleUnit;

constexpr double kDegree = std::numbers::pi / 180;

api::RobotDescription robot_of(int joints) {
  api::RobotDescription robot;
  for (int i = 1; i <= joints; ++i) {
    robot.joints.push_back({"joint_" + std::to_string(i), -3, 3, 5, 50});
  }
  return robot;
}

// Fanuc's counting: joint 3 is measured against the horizontal.
api::RobotDescription coupled_robot() {
  api::RobotDescription robot = robot_of(6);
  for (int i = 0; i < 6; ++i) robot.wire_joints.push_back({.joint = i});
  robot.wire_joints[2].couplings = {{1, 1}};
  return robot;
}

// Seven joints in another order as pulses, and an eighth number that none has.
api::RobotDescription pulse_robot() {
  api::RobotDescription robot = robot_of(7);
  for (const int joint : {0, 1, 3, 4, 5, 6, 2}) {
    robot.wire_joints.push_back({.joint = joint, .counts_per_rad = 1024 / kDegree});
  }
  robot.wire_joints[1].sign = -1;
  robot.wire_joints[5].offset_rad = 0.5;
  robot.wire_joints.push_back({});
  return robot;
}

Eigen::VectorXd random_angles(std::mt19937& engine, int count) {
  std::uniform_real_distribution<double> angle(-6, 6);
  Eigen::VectorXd angles(count);
  for (double& value : angles) value = angle(engine);
  return angles;
}

// Where the arm goes when it is held at `held`.
Eigen::VectorXd positions(const api::MoveJoints& move, const Eigen::VectorXd& held) {
  Eigen::VectorXd arm = held;
  for (const api::JointTarget& target : move.targets) {
    double position = target.position_rad;
    for (const api::JointShare& share : target.held) position += share.factor * held(share.joint);
    arm(target.joint) = position;
  }
  return arm;
}

TEST(JointMap, WithoutAConventionChangesNoBit) {
  const JointMap map(robot_of(7));
  EXPECT_EQ(map.count(), 7);
  std::mt19937 engine(1);
  for (int n = 0; n < 100; ++n) {
    const Eigen::VectorXd arm = random_angles(engine, 7);
    EXPECT_EQ(map.wire_angles(arm), arm);
    EXPECT_EQ(map.arm_angles(arm), arm);
    EXPECT_EQ(map.wire_rates(arm), arm);
    const api::MoveJoints move = map.to_move({{3, arm(2), 0.5}, {1, arm(0)}});
    ASSERT_EQ(move.targets.size(), 2U);
    EXPECT_EQ(move.targets[0].joint, 2);
    EXPECT_EQ(move.targets[0].position_rad, arm(2));
    EXPECT_EQ(move.targets[0].speed_rad_s, 0.5);
    EXPECT_TRUE(move.targets[0].held.empty());
    EXPECT_EQ(move.targets[1].speed_rad_s, std::nullopt);
  }
  EXPECT_EQ(map.from_rad(2, std::numbers::pi, AngleUnit::kDegree), 180);
  EXPECT_EQ(map.unit_name(2, AngleUnit::kRadian), "radian");
}

TEST(JointMap, RandomConventionsGoThereAndBack) {
  std::mt19937 engine(2);
  std::uniform_real_distribution<double> factor(-0.4, 0.4), scale(10, 1e5);
  std::bernoulli_distribution coin(0.5);
  for (int n = 0; n < 300; ++n) {
    const int joints = 1 + n % 7;
    api::RobotDescription robot = robot_of(joints);
    for (int i = 0; i < joints; ++i) {
      api::WireJoint& wire = robot.wire_joints.emplace_back();
      wire.joint = i;
      wire.sign = coin(engine) ? 1 : -1;
      wire.counts_per_rad = coin(engine) ? scale(engine) : 0;
      wire.offset_rad = 4 * factor(engine);
    }
    std::shuffle(robot.wire_joints.begin(), robot.wire_joints.end(), engine);
    // Each moves with those before it in the list, which can always be solved.
    for (int i = 1; i < joints; ++i) {
      auto& couplings = robot.wire_joints[static_cast<std::size_t>(i)].couplings;
      if (coin(engine)) couplings.push_back({i - 1, 4 * factor(engine)});
    }
    if (joints < 7) robot.wire_joints.push_back({});
    const JointMap map(robot);
    const Eigen::VectorXd arm = random_angles(engine, joints);
    const Eigen::VectorXd wire = map.wire_angles(arm);
    ASSERT_EQ(wire.size(), map.count());
    EXPECT_LT((map.arm_angles(wire) - arm).norm(), 1e-12);
    const Eigen::VectorXd later = arm + 0.01 * random_angles(engine, joints);
    EXPECT_LT((map.wire_rates(later - arm) - (map.wire_angles(later) - wire)).norm(), 1e-12);
    for (int number = 1; number <= map.count(); ++number) {
      const double value = map.from_rad(number, wire(number - 1), AngleUnit::kDegree);
      EXPECT_NEAR(map.to_rad(number, value, AngleUnit::kDegree), wire(number - 1), 1e-12);
    }
    // Some of the joints named: they move to their targets, the others stay as they were counted.
    Eigen::VectorXd expected = wire;
    std::vector<WireTarget> targets;
    for (int number = 1; number <= joints; ++number) {
      if (map.arm_joint(number) < 0 || !coin(engine)) continue;
      expected(number - 1) += factor(engine);
      targets.push_back({number, expected(number - 1)});
    }
    const Eigen::VectorXd moved = positions(map.to_move(targets), arm);
    EXPECT_LT((map.wire_angles(moved) - expected).norm(), 1e-11);
  }
}

TEST(JointMap, AJointThatMovesWithAnotherKeepsItsOwnCount) {
  const JointMap map(coupled_robot());
  Eigen::VectorXd held(6);
  held << 0.1, 0.4, 0.9, 0, -1, 0;
  EXPECT_DOUBLE_EQ(map.wire_angles(held)(2), 0.5);
  // Joint 2 alone: the arm's joint 3 follows it.
  const api::MoveJoints second = map.to_move({{2, 0.6, 0.25}});
  ASSERT_EQ(second.targets.size(), 2U);
  EXPECT_EQ(second.targets[1].joint, 2);
  EXPECT_EQ(second.targets[1].speed_rad_s, 0.25);
  EXPECT_DOUBLE_EQ(positions(second, held)(1), 0.6);
  EXPECT_DOUBLE_EQ(positions(second, held)(2), 1.1);
  // Joint 3 alone: joint 2 stays.
  const api::MoveJoints third = map.to_move({{3, 0.2, {}, {}, {}, 0.01}});
  ASSERT_EQ(third.targets.size(), 1U);
  EXPECT_DOUBLE_EQ(positions(third, held)(2), 0.6);
  EXPECT_EQ(third.targets[0].tolerance_rad, 0.01);
  // Both: their speeds add up, and a free one leaves the sum free.
  const api::MoveJoints both = map.to_move({{3, 0.2, 0.5}, {2, 0.6, 0.25}});
  ASSERT_EQ(both.targets.size(), 2U);
  EXPECT_EQ(both.targets[0].speed_rad_s, 0.75);
  EXPECT_TRUE(both.targets[0].held.empty());
  EXPECT_EQ(map.to_move({{3, 0.2, 0.5}, {2, 0.6}}).targets[0].speed_rad_s, std::nullopt);
}

TEST(JointMap, NumbersUnitsAndRangesAreThoseOfTheList) {
  api::RobotDescription robot = pulse_robot();
  robot.joints[3].lower_rad = -1;
  robot.joints[3].upper_rad = 2;
  robot.joints[1] = {"joint_2", -1, 2, 5, 50};
  robot.wire_joints[0].range = {-0.5, 0.25};
  const JointMap map(robot);
  EXPECT_EQ(map.count(), 8);
  EXPECT_EQ(map.number_of(2), 7);
  EXPECT_EQ(map.arm_joint(3), 3);
  EXPECT_EQ(map.arm_joint(8), -1);
  EXPECT_EQ(map.unit_name(3, AngleUnit::kDegree), "pulse");
  EXPECT_NEAR(map.from_rad(3, 10 * kDegree, AngleUnit::kRadian), 10240, 1e-9);
  EXPECT_TRUE(map.own_range(1));
  EXPECT_EQ(map.range(1).upper_rad, 0.25);
  EXPECT_FALSE(map.own_range(2));
  EXPECT_DOUBLE_EQ(map.range(2).lower_rad, -2) << "the other way round";
  EXPECT_DOUBLE_EQ(map.range(2).upper_rad, 1);
  EXPECT_DOUBLE_EQ(map.range(6).upper_rad, 2.5) << "without the offset";
  EXPECT_EQ(map.wire_angles(Eigen::VectorXd::Constant(7, 1))(7), 0) << "none";
  EXPECT_TRUE(map.to_move({{8, 1.0}}).targets.empty());
  const JointMap coupled(coupled_robot());
  EXPECT_DOUBLE_EQ(coupled.range(3).lower_rad, -6);
}

TEST(JointMap, MessagesNameTheNumbers) {
  const std::string text = "joint_3 at 190.0 deg is greater than its limit 171.9 deg";
  EXPECT_EQ(JointMap(robot_of(6)).explained(text), text + "; joint_3 is CRCL joint 3");
  EXPECT_EQ(JointMap(coupled_robot()).explained(text),
            text + "; joint_3 is CRCL joint 3 with 1 of joint 2");
  EXPECT_EQ(JointMap(pulse_robot()).explained(text),
            text + "; joint_3 is CRCL joint 7, -176013 to 176013 pulses");
  EXPECT_EQ(JointMap(robot_of(6)).explained("joint_33 and a_joint_3"), "joint_33 and a_joint_3");
  EXPECT_EQ(JointMap(robot_of(6)).explained(""), "");
}

TEST(JointMap, RefusesDescriptionsThatMakeNone) {
  api::RobotDescription robot = coupled_robot();
  robot.wire_joints[0].joint = 1;
  EXPECT_THROW(JointMap{robot}, std::invalid_argument);
  robot = coupled_robot();
  robot.wire_joints.pop_back();
  EXPECT_THROW(JointMap{robot}, std::invalid_argument);
  robot = coupled_robot();
  robot.wire_joints[1].couplings = {{2, 1}};
  EXPECT_THROW(JointMap{robot}, std::invalid_argument);
}

}  // namespace
}  // namespace aprsim::crcl_server
