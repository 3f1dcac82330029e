// Random poses for every arm: each is found, or shown not to exist by an argument that does not use
// the arm's solver. APRSIM_ARM_POSES sets the number of poses.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <ostream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/chains.hpp"
#include "world/robot/kinematics/choice/make_inverse_kinematics.hpp"
#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/kinematics/numeric/pose_solver.hpp"
#include "world/robot/model/joint_rotation.hpp"

namespace aprsim::robot {
namespace {

constexpr double kTolerance = 1e-6;  // [m, rad]

struct ReachingArm {
  const char* name;
  std::function<ArmModel()> make;
  int poses, thorough_poses;  ///< in the ordinary suite, and with APRSIM_THOROUGH
};

void PrintTo(const ReachingArm& arm, std::ostream* out) { *out << arm.name; }

int pose_count(const ReachingArm& arm) {
  if (const char* given = std::getenv("APRSIM_ARM_POSES")) return std::atoi(given);
  return std::getenv("APRSIM_THOROUGH") != nullptr ? arm.thorough_poses : arm.poses;
}

std::string text_of(const JointVector& q) {
  std::ostringstream text;
  text.precision(15);
  text << q.transpose();
  return text.str();
}

class Reach : public testing::TestWithParam<ReachingArm> {
 protected:
  void SetUp() override {
    auto ik = make_inverse_kinematics(model_);
    ASSERT_TRUE(ik) << ik.error().message;
    ik_ = std::move(*ik);
  }

  [[nodiscard]] int dof() const { return model_.dof(); }

  /// The solver's answer to a pose of which nothing else is known.
  [[nodiscard]] Result<JointVector> find(const Eigen::Isometry3d& X_BF, const JointVector& seed) {
    const auto elbow = ik_->choose_elbow(X_BF, seed);
    if (!elbow) return tl::unexpected(elbow.error());
    return ik_->nearest(X_BF, seed, *elbow);
  }

  /// Whether the posture has the flange at the pose and keeps the limits.
  [[nodiscard]] bool reaches(const JointVector& q, const Eigen::Isometry3d& X_BF,
                             double tolerance) const {
    for (int i = 0; i < dof(); ++i) {
      const Joint& joint = model_.joints[static_cast<std::size_t>(i)];
      if (q(i) < joint.lower_rad || q(i) > joint.upper_rad) return false;
    }
    const Eigen::Isometry3d X = flange_pose(model_, q);
    return (X.translation() - X_BF.translation()).norm() <= tolerance &&
           test::angle_between(X.linear(), X_BF.linear()) <= tolerance;
  }

  /// Distance of the flange from the first joint that the lengths of the links do not allow.
  [[nodiscard]] double reach_bound_m() const {
    double sum = flange_offset(model_) + longest_offset(model_.joints[0]) -
                 model_.joints[0].X_PJ.translation().norm();
    for (int i = 1; i < dof(); ++i) {
      sum += longest_offset(model_.joints[static_cast<std::size_t>(i)]);
    }
    return sum;
  }

  /// A posture at the pose by searches from random postures, which know nothing of the arm's
  /// family.
  [[nodiscard]] bool search_finds(const Eigen::Isometry3d& X_BF, int starts, JointVector& q) {
    for (int n = 0; n < starts; ++n) {
      q = test::random_q(model_, random_);
      if (solve_pose({model_, X_BF, std::nullopt, true}, q).exact) return true;
    }
    return false;
  }

  [[nodiscard]] Eigen::Vector3d in_unit_ball() {
    std::uniform_real_distribution<double> unit(-1, 1);
    Eigen::Vector3d out;
    do {
      out = {unit(random_), unit(random_), unit(random_)};
    } while (out.norm() > 1);
    return out;
  }

  /// Anywhere in the ball that the links' lengths span, in any orientation that the axes allow; or
  /// near a pose that exists, where the limit between both runs.
  [[nodiscard]] Eigen::Isometry3d pose_in_space() {
    std::uniform_real_distribution<double> angle(-3.14, 3.14), unit(0, 1);
    Eigen::Isometry3d X = flange_pose(model_, test::random_q(model_, random_));
    if (unit(random_) < 0.5) {
      X.translation() =
          model_.joints[0].X_PJ.translation() + 1.05 * reach_bound_m() * in_unit_ball();
      if (dof() > 5) {
        std::normal_distribution<double> normal;
        X.linear() =
            Eigen::Quaterniond(normal(random_), normal(random_), normal(random_), normal(random_))
                .normalized()
                .toRotationMatrix();
      }
    } else {
      X.translation() += 0.05 * in_unit_ball();
      if (dof() > 5) {
        X.rotate(Eigen::AngleAxisd(0.3 * unit(random_), in_unit_ball().normalized()));
      }
    }
    if (dof() == 4) X.prerotate(Eigen::AngleAxisd(angle(random_), Eigen::Vector3d::UnitZ()));
    return X;
  }

  ArmModel model_ = GetParam().make();
  std::unique_ptr<InverseKinematics> ik_;
  std::mt19937_64 random_{41};
};

TEST_P(Reach, EveryPoseOfTheArmIsFoundFromAnyPosture) {
  const int poses = pose_count(GetParam());
  int missed = 0;
  for (int n = 0; n < poses; ++n) {
    const JointVector q = test::random_q(model_, random_);
    const Eigen::Isometry3d X_BF = flange_pose(model_, q);
    const auto found = find(X_BF, test::random_q(model_, random_));
    if (!found) {
      if (++missed <= 5) ADD_FAILURE() << found.error().message << ": " << text_of(q);
      continue;
    }
    ASSERT_TRUE(reaches(*found, X_BF, kTolerance)) << text_of(q) << " -> " << text_of(*found);
  }
  EXPECT_EQ(missed, 0) << "of " << poses;
}

INSTANTIATE_TEST_SUITE_P(
    Arms, Reach,
    testing::Values(ReachingArm{"fanuc", test::fanuc, 20000, 100000},
                    ReachingArm{"motoman", test::motoman, 4000, 100000},
                    ReachingArm{"ur5e", [] { return test::load("ur5e"); }, 20000, 100000},
                    ReachingArm{"irb120", [] { return test::load("irb120"); }, 20000, 100000},
                    ReachingArm{"panda", [] { return test::load("panda"); }, 4000, 100000},
                    ReachingArm{"scara", [] { return test::load("scara600"); }, 20000, 100000},
                    ReachingArm{"skew_six", test::skew_six, 20, 2000},
                    ReachingArm{"five_axes", test::five_axes, 20, 2000},
                    ReachingArm{"rail_seven", test::rail_seven, 20, 2000},
                    ReachingArm{"gantry_six", test::gantry_six, 20, 2000},
                    ReachingArm{"skew_seven", test::skew_seven, 20, 2000}),
    [](const auto& which) { return std::string(which.param.name); });

/// Arms of makers, whose solvers have closed forms.
class ReachInSpace : public Reach {
 protected:
  static constexpr int kStarts = 40;  ///< of a search for a pose that the solver refuses
};

TEST_P(ReachInSpace, APoseThatIsRefusedDoesNotExist) {
  const int poses = pose_count(GetParam());
  const int most_searches = std::max(100, poses / 20);
  const Eigen::Vector3d first = model_.joints[0].X_PJ.translation();
  int found_poses = 0, too_far = 0, refused = 0, searched = 0, wrong = 0;
  for (int n = 0; n < poses; ++n) {
    const Eigen::Isometry3d X_BF = pose_in_space();
    const auto found = find(X_BF, test::random_q(model_, random_));
    const bool far = (X_BF.translation() - first).norm() > reach_bound_m() + 1e-9;
    if (found) {
      ASSERT_FALSE(far);
      ASSERT_TRUE(reaches(*found, X_BF, kTolerance)) << text_of(*found);
      ++found_poses;
      continue;
    }
    EXPECT_EQ(found.error().code, ErrorCode::kUnreachable);
    ++refused;
    if (far) {
      ++too_far;
    } else if (searched < most_searches) {
      ++searched;
      JointVector q;
      if (search_finds(X_BF, kStarts, q) && ++wrong <= 5) {
        ADD_FAILURE() << found.error().message << ", but it is reached at " << text_of(q);
      }
    }
  }
  EXPECT_EQ(wrong, 0) << "of " << searched;
  EXPECT_GT(found_poses, poses / 50);
  EXPECT_GT(too_far, 0);
  EXPECT_GT(searched, 0);
  RecordProperty("found", found_poses);
  RecordProperty("refused", refused);
  RecordProperty("beyond_all_links", too_far);
  RecordProperty("searched", searched);
}

INSTANTIATE_TEST_SUITE_P(
    Arms, ReachInSpace,
    testing::Values(ReachingArm{"fanuc", test::fanuc, 1000, 100000},
                    ReachingArm{"motoman", test::motoman, 1000, 100000},
                    ReachingArm{"ur5e", [] { return test::load("ur5e"); }, 1000, 100000},
                    ReachingArm{"irb120", [] { return test::load("irb120"); }, 1000, 100000},
                    ReachingArm{"panda", [] { return test::load("panda"); }, 1000, 100000},
                    ReachingArm{"scara", [] { return test::load("scara600"); }, 1000, 100000}),
    [](const auto& which) { return std::string(which.param.name); });

}  // namespace
}  // namespace aprsim::robot
