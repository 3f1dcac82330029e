#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/test_arms.hpp"
#include "world/robot/kinematics/choice/make_inverse_kinematics.hpp"
#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::robot {
namespace {

using test::kDegree;
constexpr int kPoses = 100000;

std::unique_ptr<InverseKinematics> make(const ArmModel& model) {
  auto ik = make_inverse_kinematics(model);
  EXPECT_TRUE(ik) << ik.error().message;
  return std::move(*ik);
}

struct Worst {
  double position = 0, rotation = 0, recovery = 0;
  void pose(const ArmModel& model, const JointVector& q, const Eigen::Isometry3d& X_BF) {
    const Eigen::Isometry3d X = flange_pose(model, q);
    position = std::max(position, (X.translation() - X_BF.translation()).norm());
    rotation = std::max(rotation, test::angle_between(X.linear(), X_BF.linear()));
  }
};

bool within_limits(const ArmModel& model, const JointVector& q) {
  for (int i = 0; i < model.dof(); ++i) {
    const Joint& joint = model.joints[static_cast<std::size_t>(i)];
    if (q(i) < joint.lower_rad || q(i) > joint.upper_rad) return false;
  }
  return true;
}

/// The measure of nearest(): squared, in joint ranges.
double distance_in_ranges(const ArmModel& model, const JointVector& a, const JointVector& b) {
  double sum = 0;
  for (int i = 0; i < model.dof(); ++i) {
    const Joint& joint = model.joints[static_cast<std::size_t>(i)];
    const double step = (a(i) - b(i)) / (joint.upper_rad - joint.lower_rad);
    sum += step * step;
  }
  return sum;
}

class Ik : public testing::TestWithParam<bool> {
 protected:
  ArmModel model_ = GetParam() ? test::fanuc() : test::motoman();
  std::unique_ptr<InverseKinematics> ik_ = make(model_);
  std::mt19937_64 random_{11};
};

TEST_P(Ik, AllSolutionsReachThePoseAndTheSourceIsAmongThem) {
  Worst worst;
  int missed = 0;
  std::size_t solutions = 0;
  for (int n = 0; n < kPoses; ++n) {
    const JointVector q = test::random_q(model_, random_);
    const Eigen::Isometry3d X_BF = flange_pose(model_, q);
    double nearest = 1e9;
    for (const IkSolution& solution : ik_->all(X_BF, ik_->elbow_of(q))) {
      ++solutions;
      ASSERT_TRUE(within_limits(model_, solution.q));
      worst.pose(model_, solution.q, X_BF);
      nearest = std::min(nearest, (solution.q - q).cwiseAbs().maxCoeff());
    }
    // Near singularities a joint vector is worth fewer digits than the pose that it reaches.
    if (nearest > 1e-6) ++missed;
    worst.recovery = std::max(worst.recovery, nearest);
  }
  EXPECT_LE(worst.position, 1e-9);
  EXPECT_LE(worst.rotation, 1e-9);
  EXPECT_EQ(missed, 0);
  std::printf("%s: %.2g m, %.2g rad, source recovered to %.2g rad, %.2f solutions a pose\n",
              model_.name.c_str(), worst.position, worst.rotation, worst.recovery,
              static_cast<double>(solutions) / kPoses);
}

TEST_P(Ik, NearestFromTheSourceIsTheSource) {
  for (int n = 0; n < 20000; ++n) {
    const JointVector q = test::random_q(model_, random_);
    const auto found = ik_->nearest(flange_pose(model_, q), q, ik_->elbow_of(q));
    ASSERT_TRUE(found) << found.error().message;
    ASSERT_LT((*found - q).cwiseAbs().maxCoeff(), 1e-6);
  }
}

TEST_P(Ik, NearestIsTheBestOfAll) {
  for (int n = 0; n < 5000; ++n) {
    const JointVector q = test::random_q(model_, random_);
    const JointVector seed = test::random_q(model_, random_);
    const Eigen::Isometry3d X_BF = flange_pose(model_, q);
    double best = 1e9;
    for (const IkSolution& solution : ik_->all(X_BF, ik_->elbow_of(q))) {
      best = std::min(best, distance_in_ranges(model_, solution.q, seed));
    }
    const auto found = ik_->nearest(X_BF, seed, ik_->elbow_of(q));
    ASSERT_TRUE(found);
    ASSERT_NEAR(distance_in_ranges(model_, *found, seed), best, 1e-9);
  }
}

/// A path in joint space, called every millisecond: never a longer step than the path itself makes,
/// and the path's own joint vector but for the few steps across a singularity, where two branches
/// meet and the other one may be nearer.
TEST_P(Ik, NearestFollowsAPathInSmallSteps) {
  constexpr int kSteps = 1000, kPaths = 30;
  int other_branch = 0;
  for (int path = 0; path < kPaths; ++path) {
    const JointVector from = test::random_q(model_, random_), to = test::random_q(model_, random_);
    JointVector seed = from;
    for (int k = 1; k <= kSteps; ++k) {
      const JointVector q = from + (to - from) * (static_cast<double>(k) / kSteps);
      const auto found = ik_->nearest(flange_pose(model_, q), seed, ik_->elbow_of(q));
      ASSERT_TRUE(found) << found.error().message;
      ASSERT_LE(std::sqrt(distance_in_ranges(model_, *found, seed)),
                std::sqrt(distance_in_ranges(model_, q, seed)) + 1e-7);
      if ((*found - q).cwiseAbs().maxCoeff() > 1e-6) ++other_branch;
      seed = q;
    }
  }
  EXPECT_LT(other_branch, kSteps * kPaths / 500);
}

TEST_P(Ik, SingularPosesAreExact) {
  Worst worst;
  for (int n = 0; n < 20000; ++n) {
    JointVector q = test::random_q(model_, random_, 0.95);
    // Every mixture of exactly and nearly singular: the wrist, the elbow and the shoulder.
    const double off = std::array{0.0, 1e-12, 1e-10, 1e-9, 1e-7, 1e-4}[random_() % 6];
    if (GetParam()) {
      if (n % 2 == 0) q(4) = off;
      if (n % 3 == 0) q(2) = std::numbers::pi / 2 - std::atan2(.035, .335) + off;
    } else {
      if (n % 2 == 0) q(5) = off;
      if (n % 3 == 0) q(3) = off;
      if (n % 5 == 0) q(1) = off;
    }
    const Eigen::Isometry3d X_BF = flange_pose(model_, q);
    const auto found = ik_->nearest(X_BF, q, ik_->elbow_of(q));
    ASSERT_TRUE(found) << found.error().message << " " << q.transpose();
    worst.pose(model_, *found, X_BF);
  }
  EXPECT_LE(worst.position, 1e-9);
  EXPECT_LE(worst.rotation, 1e-9);
}

TEST_P(Ik, OutOfReachNamesTheDistance) {
  Eigen::Isometry3d X_BF = flange_pose(model_, test::home(model_));
  X_BF.translation().x() += 2;
  const auto found = ik_->nearest(X_BF, test::home(model_), 0);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kUnreachable);
  EXPECT_EQ(found.error().field, "position");
  EXPECT_NE(found.error().message.find("out of reach by 1."), std::string::npos)
      << found.error().message;
  EXPECT_TRUE(ik_->all(X_BF, 0).empty());
  EXPECT_FALSE(ik_->choose_elbow(X_BF, test::home(model_)));
}

TEST_P(Ik, NotANumberIsRefused) {
  Eigen::Isometry3d X_BF = flange_pose(model_, test::home(model_));
  X_BF.translation().x() = std::nan("");
  EXPECT_FALSE(ik_->nearest(X_BF, test::home(model_), 0));
  EXPECT_TRUE(ik_->all(X_BF, 0).empty());
}

INSTANTIATE_TEST_SUITE_P(Arms, Ik, testing::Bool(),
                         [](const auto& which) { return which.param ? "fanuc" : "motoman"; });

TEST(FanucIk, ExactReachAndOneMillimetreMore) {
  const ArmModel model = test::fanuc();
  const auto ik = make(model);
  JointVector q = test::home(model);
  q(1) = 50 * kDegree;
  q(2) = std::numbers::pi / 2 - std::atan2(.035, .335);  // forearm in line with the upper arm
  const Eigen::Isometry3d X_BF = flange_pose(model, q);
  ASSERT_TRUE(ik->nearest(X_BF, q, 0));
  Eigen::Isometry3d beyond = X_BF;
  beyond.translation() += 1e-3 * Eigen::Vector3d(std::sin(q(1)), 0, std::cos(q(1)));
  const auto found = ik->nearest(beyond, q, 0);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().message.substr(0, 48),
            "out of reach by 0.0010 m: wrist at 0.6678 m from");
  EXPECT_NE(found.error().message.find("limit 0.6668 m"), std::string::npos)
      << found.error().message;
}

TEST(FanucIk, LimitIsNamedWithJointValueAndLimit) {
  const ArmModel model = test::fanuc();
  const auto ik = make(model);
  JointVector q = test::home(model);
  q(4) = -126.5 * kDegree;  // beyond -125 deg; the flipped wrist is beyond +125
  const auto found = ik->nearest(flange_pose(model, q), q, 0);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().field, "joint_5");
  EXPECT_EQ(found.error().message, "joint_5 would be at -126.5 deg, limit -125 deg");
}

TEST(FanucIk, FullTurnsOfTheFlange) {
  const ArmModel model = test::fanuc();
  const auto ik = make(model);
  JointVector q = test::home(model);
  q(5) = 300 * kDegree;
  const Eigen::Isometry3d X_BF = flange_pose(model, q);
  JointVector seed = q;
  EXPECT_NEAR((*ik->nearest(X_BF, seed, 0))(5), 300 * kDegree, 1e-9);
  seed(5) = -50 * kDegree;
  EXPECT_NEAR((*ik->nearest(X_BF, seed, 0))(5), -60 * kDegree, 1e-9);
}

TEST(FanucIk, LineThroughTheWristSingularity) {
  // Flange straight ahead, moving sideways: joint 5 passes 0 in the middle and changes sign.
  const ArmModel model = test::fanuc();
  const auto ik = make(model);
  Eigen::Isometry3d X_BF = Eigen::Isometry3d::Identity();
  X_BF.translation() << .465, -.15, .695;
  JointVector q = *ik->nearest(X_BF, JointVector::Zero(6), 0);
  for (int k = 1; k <= 1200; ++k) {
    X_BF.translation().y() = -.15 + 2.5e-4 * k;
    const auto next = ik->nearest(X_BF, q, 0);
    ASSERT_TRUE(next);
    ASSERT_LT((*next - q).cwiseAbs().maxCoeff(), 2e-3) << k;
    q = *next;
  }
}

TEST(MotomanIk, ElbowAngleIsKept) {
  const ArmModel model = test::motoman();
  const auto ik = make(model);
  const Eigen::Isometry3d X_BF = flange_pose(model, test::home(model));
  JointVector seed = test::home(model);
  for (double elbow = 0; elbow < 0.8; elbow += 0.01) {
    const auto q = ik->nearest(X_BF, seed, elbow);
    ASSERT_TRUE(q) << q.error().message;
    EXPECT_NEAR(ik->elbow_of(*q), elbow, 1e-9);
    seed = *q;
  }
}

TEST(MotomanIk, ChosenElbowIsReachableAndAwayFromLimits) {
  const ArmModel model = test::motoman();
  const auto ik = make(model);
  const JointVector seed = test::home(model);
  std::mt19937_64 random{3};
  std::uniform_real_distribution<double> x(-.75, .75), y(-.75, -.25), yaw(-3.1, 3.1);
  int reached = 0, tried = 0;
  for (int n = 0; n < 300; ++n) {
    Eigen::Isometry3d X_BF = Eigen::Isometry3d::Identity();
    X_BF.translation() << x(random), y(random), .33;  // tool down over the conveyor
    X_BF.linear() = (Eigen::AngleAxisd(yaw(random), Eigen::Vector3d::UnitZ()) *
                     Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()))
                        .toRotationMatrix();
    bool possible = false;
    for (double elbow = -3.14; elbow < 3.14 && !possible; elbow += 0.02) {
      possible = ik->nearest(X_BF, seed, elbow).has_value();
    }
    const auto elbow = ik->choose_elbow(X_BF, seed);
    ++tried;
    if (possible) {
      EXPECT_TRUE(elbow) << X_BF.translation().transpose();
    }
    if (!elbow) continue;
    ++reached;
    const auto q = ik->nearest(X_BF, seed, *elbow);
    ASSERT_TRUE(q) << q.error().message;
    ASSERT_TRUE(within_limits(model, *q));
  }
  EXPECT_GT(reached, tried / 2);
}

TEST(MotomanIk, ChosenElbowKeepsTheHomePosture) {
  const ArmModel model = test::motoman();
  const auto ik = make(model);
  const JointVector home = test::home(model);
  const auto elbow = ik->choose_elbow(flange_pose(model, home), home);
  ASSERT_TRUE(elbow);
  EXPECT_LT((*ik->nearest(flange_pose(model, home), home, *elbow) - home).norm(), 0.05);
}

TEST(MakeIk, OtherGeometryIsSolvedNumerically) {
  ArmModel six = test::fanuc();
  six.joints[4].X_PJ.translation().y() = 0.01;
  ArmModel seven = test::motoman();
  seven.joints[3].axis = Eigen::Vector3d::UnitX();
  std::mt19937_64 random(2);
  for (const ArmModel& model : {six, seven}) {
    const auto ik = make(model);
    for (int n = 0; n < 5; ++n) {
      const JointVector q = test::random_q(model, random, 0.9);
      const Eigen::Isometry3d X_BF = flange_pose(model, q);
      const auto found = ik->nearest(X_BF, q, ik->elbow_of(q));
      ASSERT_TRUE(found) << found.error().message;
      EXPECT_LT((flange_pose(model, *found).matrix() - X_BF.matrix()).norm(), 1e-7);
    }
  }
}

}  // namespace
}  // namespace aprsim::robot
