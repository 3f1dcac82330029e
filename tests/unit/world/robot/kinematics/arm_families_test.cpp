// Inverse kinematics of arms beside the two of the cell: families in closed form, in whatever
// frames an arm is described, and the numeric solver.

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <ostream>

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.hpp"
#include "tests/unit/world/robot/chains.hpp"
#include "tests/unit/world/robot/test_arms.hpp"
#include "world/robot/kinematics/choice/make_inverse_kinematics.hpp"
#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/kinematics/families/placed_ik.hpp"
#include "world/robot/kinematics/numeric/numeric_ik.hpp"
#include "world/robot/kinematics/pose_projection.hpp"

namespace aprsim::robot {
namespace {

std::unique_ptr<InverseKinematics> solver(const ArmModel& model) {
  auto ik = make_inverse_kinematics(model);
  EXPECT_TRUE(ik) << ik.error().message;
  return std::move(*ik);
}

Eigen::Matrix3d random_rotation(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const Eigen::Quaterniond q(normal(random), normal(random), normal(random), normal(random));
  return q.normalized().toRotationMatrix();
}

/// The same arm in other frames, with other senses and zeros of its angles.
ArmModel described_anew(const ArmModel& model, std::mt19937_64& random) {
  std::uniform_real_distribution<double> number(-0.5, 0.5);
  ArmModel out = model;
  Eigen::Isometry3d before = Eigen::Isometry3d::Identity();
  for (Joint& joint : out.joints) {
    const double zero = joint.prismatic ? 0.1 * number(random) : number(random);
    const double sense = number(random) < 0 ? -1 : 1;
    // A frame anywhere on the axis, turned at will.
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    frame.linear() = random_rotation(random);
    frame.translation() = number(random) * joint.axis;
    Eigen::Isometry3d at_zero = Eigen::Isometry3d::Identity();
    if (joint.prismatic) {
      at_zero.translation() = zero * joint.axis;
    } else {
      at_zero.linear() = Eigen::AngleAxisd(zero, joint.axis).toRotationMatrix();
    }
    joint.X_PJ = before.inverse() * joint.X_PJ * at_zero * frame;
    joint.axis = sense * (frame.linear().transpose() * joint.axis);
    const double first = sense * (joint.lower_rad - zero), last = sense * (joint.upper_rad - zero);
    joint.lower_rad = std::min(first, last);
    joint.upper_rad = std::max(first, last);
    before = frame;
  }
  out.X_LF = before.inverse() * model.X_LF.value_or(Eigen::Isometry3d::Identity());
  return out;
}

double distance(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return std::max((a.translation() - b.translation()).norm(),
                  test::angle_between(a.linear(), b.linear()));
}

/// Allocations of searches along a joint path that all succeed.
long allocations_along_a_path(const ArmModel& model, const InverseKinematics& ik,
                              std::mt19937_64& random) {
  const JointVector from = test::random_q(model, random, 0.5);
  const JointVector to = from + 0.05 * (test::random_q(model, random, 0.5) - from);
  JointVector seed = from;
  const long before = aprsim::test::allocations();
  bool found = true;
  for (int k = 1; k <= 20; ++k) {
    const JointVector q = from + (to - from) * (k / 20.0);
    found = ik.nearest(flange_pose(model, q), seed, ik.elbow_of(q)).has_value() && found;
    seed = q;
  }
  const long count = aprsim::test::allocations() - before;
  EXPECT_TRUE(found);
  return count;
}

bool keeps_limits(const ArmModel& model, const JointVector& q) {
  for (int i = 0; i < model.dof(); ++i) {
    const Joint& joint = model.joints[static_cast<std::size_t>(i)];
    if (q(i) < joint.lower_rad || q(i) > joint.upper_rad) return false;
  }
  return true;
}

// ---- families in closed form

class ClosedForm : public testing::TestWithParam<const char*> {
 protected:
  ArmModel model_ = test::load(GetParam());
  std::mt19937_64 random_{17};

  /// Every solution reaches its pose within limits, and the posture that gave the pose is found.
  void expect_solved(const ArmModel& model, int poses) {
    const auto ik = solver(model);
    double worst = 0;
    for (int n = 0; n < poses; ++n) {
      const JointVector q = test::random_q(model, random_);
      const Eigen::Isometry3d X_BF = flange_pose(model, q);
      double nearest = 1e9;
      for (const IkSolution& solution : ik->all(X_BF, ik->elbow_of(q))) {
        ASSERT_TRUE(keeps_limits(model, solution.q));
        worst = std::max(worst, distance(flange_pose(model, solution.q), X_BF));
        nearest = std::min(nearest, (solution.q - q).cwiseAbs().maxCoeff());
      }
      ASSERT_LT(nearest, 1e-6) << q.transpose();
      const JointVector seed = test::random_q(model, random_);
      const auto found = ik->nearest(X_BF, seed, ik->elbow_of(q));
      ASSERT_TRUE(found) << found.error().message;
      worst = std::max(worst, distance(flange_pose(model, *found), X_BF));
    }
    EXPECT_LT(worst, 1e-9);
  }
};

TEST_P(ClosedForm, FindsEveryPoseAndItsSource) { expect_solved(model_, 10000); }

TEST_P(ClosedForm, IsFoundInEveryDescriptionOfTheArm) {
  for (int n = 0; n < 20; ++n) {
    const ArmModel anew = described_anew(model_, random_);
    const auto ik = solver(anew);
    ASSERT_NE(dynamic_cast<const PlacedIk*>(ik.get()), nullptr) << n;
    expect_solved(anew, 100);
  }
}

TEST_P(ClosedForm, SingularPosturesAreExact) {
  const auto ik = solver(model_);
  for (int n = 0; n < 2000; ++n) {
    JointVector q = test::random_q(model_, random_, 0.9);
    const double off = std::array{0.0, 1e-12, 1e-9, 1e-7, 1e-4}[random_() % 5];
    for (int i = 1; i < model_.dof(); ++i) {
      const Joint& joint = model_.joints[static_cast<std::size_t>(i)];
      if (random_() % 3 == 0 && joint.lower_rad < 0 && joint.upper_rad > off) q(i) = off;
    }
    const Eigen::Isometry3d X_BF = flange_pose(model_, q);
    const auto found = ik->nearest(X_BF, q, ik->elbow_of(q));
    ASSERT_TRUE(found) << found.error().message << " " << q.transpose();
    ASSERT_LT(distance(flange_pose(model_, *found), X_BF), 1e-9) << q.transpose();
  }
}

TEST_P(ClosedForm, BeyondReachIsRefusedWithTheDistance) {
  const auto ik = solver(model_);
  for (int n = 0; n < 200; ++n) {
    const JointVector q = test::random_q(model_, random_);
    Eigen::Isometry3d X_BF = flange_pose(model_, q);
    const double yaw = std::uniform_real_distribution<double>(-3, 3)(random_);
    X_BF.translation() += 3 * Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0);
    const auto found = ik->nearest(X_BF, q, ik->elbow_of(q));
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, ErrorCode::kUnreachable);
    EXPECT_EQ(found.error().field, "position");
    EXPECT_NE(found.error().message.find("out of reach by"), std::string::npos);
    EXPECT_TRUE(ik->all(X_BF, ik->elbow_of(q)).empty());
  }
}

TEST_P(ClosedForm, PostureNamesABranch) {
  // Postures of one pose and elbow angle that differ by more than full turns differ in a sign.
  const auto ik = solver(model_);
  const auto same_branch = [&](const JointVector& a, const JointVector& b) {
    const api::Posture p = ik->posture_of(a), r = ik->posture_of(b);
    return p.shoulder == r.shoulder && p.elbow == r.elbow && p.wrist == r.wrist;
  };
  int doubtful = 0;
  for (int n = 0; n < 300; ++n) {
    const JointVector q = test::random_q(model_, random_, 0.9);
    const auto all = ik->all(flange_pose(model_, q), ik->elbow_of(q));
    for (const IkSolution& other : all) {
      double apart = 0;
      for (int i = 0; i < model_.dof(); ++i) {
        const double step = other.q(i) - all.front().q(i);
        const bool slides = model_.joints[static_cast<std::size_t>(i)].prismatic;
        const double way = slides ? step : std::remainder(step, 2 * std::numbers::pi);
        apart = std::max(apart, std::abs(way));
      }
      if (apart > 1e-3 && same_branch(other.q, all.front().q)) ++doubtful;
    }
  }
  EXPECT_EQ(doubtful, 0);
}

TEST_P(ClosedForm, ASuccessfulSearchDoesNotAllocate) {
  EXPECT_EQ(allocations_along_a_path(model_, *solver(model_), random_), 0);
}

INSTANTIATE_TEST_SUITE_P(Arms, ClosedForm, testing::Values("ur5e", "irb120", "panda", "scara600"),
                         [](const auto& which) { return std::string(which.param); });

TEST(ClosedFormOfTheCell, HoldsInEveryDescription) {
  std::mt19937_64 random(3);
  for (const ArmModel& model : {test::fanuc(), test::motoman()}) {
    for (int n = 0; n < 10; ++n) {
      const ArmModel anew = described_anew(model, random);
      const auto ik = solver(anew);
      ASSERT_NE(dynamic_cast<const PlacedIk*>(ik.get()), nullptr) << model.name;
      for (int k = 0; k < 50; ++k) {
        const JointVector q = test::random_q(anew, random);
        const Eigen::Isometry3d X_BF = flange_pose(anew, q);
        const auto found = ik->nearest(X_BF, q, ik->elbow_of(q));
        ASSERT_TRUE(found) << found.error().message;
        ASSERT_LT((*found - q).cwiseAbs().maxCoeff(), 1e-6);
      }
    }
  }
}

TEST(ScaraIk, TiltIsRefusedWithItsAngle) {
  const ArmModel model = test::load("scara600");
  const auto ik = solver(model);
  const JointVector q = (JointVector(4) << 0.3, 0.8, -0.1, 0.2).finished();
  Eigen::Isometry3d X_BF = flange_pose(model, q);
  X_BF.linear() = X_BF.linear() *
                  Eigen::AngleAxisd(3 * test::kDegree, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const auto found = ik->nearest(X_BF, q, 0);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().field, "orientation");
  EXPECT_EQ(found.error().message,
            "tilted by 3.000 deg against the poses that the arm's 4 axes can reach here");
}

TEST(ScaraIk, StrokeIsNamedInMillimetres) {
  const ArmModel model = test::load("scara600");
  const auto ik = solver(model);
  const JointVector q = (JointVector(4) << 0.3, 0.8, -0.1, 0.2).finished();
  Eigen::Isometry3d X_BF = flange_pose(model, q);
  X_BF.translation().z() -= 0.15;
  const auto found = ik->nearest(X_BF, q, 0);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().field, "joint_3");
  EXPECT_EQ(found.error().message, "joint_3 would be at -250.000 mm, limit -200 mm");
}

TEST(PandaIk, ElbowAngleIsThatOfTheLastJoint) {
  const ArmModel model = test::load("panda");
  const auto ik = solver(model);
  std::mt19937_64 random(5);
  for (int n = 0; n < 100; ++n) {
    const JointVector q = test::random_q(model, random);
    EXPECT_DOUBLE_EQ(ik->elbow_of(q), q(6));
    const auto elbow = ik->choose_elbow(flange_pose(model, q), q);
    ASSERT_TRUE(elbow) << elbow.error().message;
    ASSERT_TRUE(ik->nearest(flange_pose(model, q), q, *elbow));
  }
}

// ---- the numeric solver

struct Chain {
  const char* name;
  std::function<ArmModel()> make;
};

void PrintTo(const Chain& chain, std::ostream* out) { *out << chain.name; }

class NumericForm : public testing::TestWithParam<Chain> {
 protected:
  ArmModel model_ = GetParam().make();
  std::unique_ptr<InverseKinematics> ik_ = solver(model_);
  std::mt19937_64 random_{23};
};

TEST_P(NumericForm, TakesWhatNoFamilyHas) {
  EXPECT_NE(dynamic_cast<const NumericIk*>(ik_.get()), nullptr);
}

TEST_P(NumericForm, FindsEveryPoseFromAnySeed) {
  double worst = 0;
  for (int n = 0; n < 250; ++n) {
    const JointVector q = test::random_q(model_, random_);
    const Eigen::Isometry3d X_BF = flange_pose(model_, q);
    const auto found = ik_->nearest(X_BF, test::random_q(model_, random_), ik_->elbow_of(q));
    ASSERT_TRUE(found) << found.error().message << " " << q.transpose();
    ASSERT_TRUE(keeps_limits(model_, *found));
    worst = std::max(worst, distance(flange_pose(model_, *found), X_BF));
  }
  EXPECT_LT(worst, 1e-7);
}

TEST_P(NumericForm, FollowsItsBranchInSmallSteps) {
  for (int path = 0; path < 10; ++path) {
    const JointVector from = test::random_q(model_, random_, 0.9);
    const JointVector to = from + 0.2 * (test::random_q(model_, random_, 0.9) - from);
    JointVector seed = from;
    for (int k = 1; k <= 50; ++k) {
      const JointVector q = from + (to - from) * (k / 50.0);
      const auto found = ik_->nearest(flange_pose(model_, q), seed, ik_->elbow_of(q));
      ASSERT_TRUE(found) << found.error().message;
      // The branch is the seed's, unless two of them meet here.
      ASSERT_LT((*found - seed).cwiseAbs().maxCoeff(), 0.35);
      ASSERT_LT(distance(flange_pose(model_, *found), flange_pose(model_, q)), 1e-7);
      seed = q;
    }
  }
}

TEST_P(NumericForm, TheSameArgumentsGiveTheSameBits) {
  const auto again = solver(model_);
  for (int n = 0; n < 20; ++n) {
    const JointVector q = test::random_q(model_, random_), seed = test::random_q(model_, random_);
    const Eigen::Isometry3d X_BF = flange_pose(model_, q);
    const auto one = ik_->nearest(X_BF, seed, ik_->elbow_of(q));
    const auto other = again->nearest(X_BF, seed, ik_->elbow_of(q));
    ASSERT_TRUE(one && other);
    EXPECT_EQ(*one, *other);
  }
}

TEST_P(NumericForm, BeyondReachIsRefused) {
  const JointVector q = test::random_q(model_, random_);
  Eigen::Isometry3d X_BF = flange_pose(model_, q);
  for (const double away : {1.0, 5.0}) {
    X_BF.translation() = away * Eigen::Vector3d(2, 1, 1);
    const auto found = ik_->nearest(X_BF, q, ik_->elbow_of(q));
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, ErrorCode::kUnreachable);
  }
  EXPECT_TRUE(ik_->all(X_BF, 0).empty());
}

class RedundantChain : public NumericForm {};

TEST_P(RedundantChain, ElbowIsKept) {
  for (int n = 0; n < 50; ++n) {
    const JointVector q = test::random_q(model_, random_);
    const Eigen::Isometry3d X_BF = flange_pose(model_, q);
    const auto found = ik_->nearest(X_BF, test::random_q(model_, random_), ik_->elbow_of(q));
    ASSERT_TRUE(found);
    EXPECT_NEAR(ik_->elbow_of(*found), ik_->elbow_of(q), 1e-9);
    const auto elbow = ik_->choose_elbow(X_BF, q);
    ASSERT_TRUE(elbow);
    EXPECT_NEAR(*elbow, ik_->elbow_of(q), 1e-6);
  }
}

TEST_P(NumericForm, ASuccessfulSearchDoesNotAllocate) {
  EXPECT_EQ(allocations_along_a_path(model_, *ik_, random_), 0);
  // From far away, too, where all starts are tried.
  const JointVector q = test::random_q(model_, random_), seed = test::random_q(model_, random_);
  const Eigen::Isometry3d X_BF = flange_pose(model_, q);
  const long before = aprsim::test::allocations();
  const bool found = ik_->nearest(X_BF, seed, ik_->elbow_of(q)).has_value();
  EXPECT_EQ(aprsim::test::allocations() - before, 0);
  EXPECT_TRUE(found);
}

INSTANTIATE_TEST_SUITE_P(Chains, NumericForm,
                         testing::Values(Chain{"skew_six", test::skew_six},
                                         Chain{"five_axes", test::five_axes},
                                         Chain{"rail_seven", test::rail_seven},
                                         Chain{"gantry_six", test::gantry_six},
                                         Chain{"skew_seven", test::skew_seven}),
                         [](const auto& which) { return std::string(which.param.name); });
INSTANTIATE_TEST_SUITE_P(Chains, RedundantChain,
                         testing::Values(Chain{"rail_seven", test::rail_seven},
                                         Chain{"skew_seven", test::skew_seven}),
                         [](const auto& which) { return std::string(which.param.name); });

TEST(FiveAxes, TiltIsRefusedWithItsAngle) {
  const ArmModel model = test::five_axes();
  const auto ik = solver(model);
  const JointVector q = (JointVector(5) << 0.3, 0.5, 0.8, 0.4, 0.2).finished();
  Eigen::Isometry3d X_BF = flange_pose(model, q);
  // About the axis that the arm lacks: horizontal, in the arm's plane.
  const Eigen::Vector3d lacking(std::cos(q(0)), std::sin(q(0)), 0);
  X_BF.linear() = Eigen::AngleAxisd(5 * test::kDegree, lacking).toRotationMatrix() * X_BF.linear();
  const auto found = ik->nearest(X_BF, q, 0);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().field, "orientation");
  EXPECT_TRUE(found.error().message.starts_with("tilted by ")) << found.error().message;
}

TEST(FiveAxes, ProjectionReachesThePoseToo) {
  const ArmModel model = test::five_axes();
  std::mt19937_64 random(9);
  for (int n = 0; n < 100; ++n) {
    const JointVector q = test::random_q(model, random, 0.8);
    if (dexterity(model, q) < 1e-3) continue;
    JointVector near = q;
    near.array() += 0.01;
    ASSERT_TRUE(project_to_pose(model, flange_pose(model, q), near));
    ASSERT_LT(distance(flange_pose(model, near), flange_pose(model, q)), 1e-9);
  }
}

TEST(ArmChoice, ThreeJointsAreRefused) {
  ArmModel model = test::five_axes();
  model.joints.resize(3);
  model.links.resize(4);
  const auto ik = make_inverse_kinematics(model);
  ASSERT_FALSE(ik);
  EXPECT_EQ(ik.error().message, "\"five_axes\" has 3 joints, expected 4 to 7");
}

}  // namespace
}  // namespace aprsim::robot
