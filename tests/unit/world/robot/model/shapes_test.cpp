#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/test_arms.hpp"
#include "world/robot/kinematics/choice/make_inverse_kinematics.hpp"
#include "world/robot/kinematics/dynamics.hpp"

/// The arms' collision shapes must not touch themselves where the real arms do not: every such
/// touch would stop the robot.
namespace aprsim::robot {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

std::vector<Vector3d> lattice(const LinkShape& shape) {
  std::vector<Vector3d> points;
  if (const auto* box = std::get_if<BoxShape>(&shape.shape)) {
    for (int i = -3; i <= 3; ++i) {
      for (int j = -3; j <= 3; ++j) {
        for (int k = -3; k <= 3; ++k) {
          const Vector3d cell(i, j, k);
          points.push_back(shape.X_LS * Vector3d(cell.cwiseProduct(box->size) / 6));
        }
      }
    }
  } else if (const auto* cylinder = std::get_if<CylinderShape>(&shape.shape)) {
    for (int a = 0; a < 16; ++a) {
      const double angle = a * std::numbers::pi / 8;
      for (int r = 1; r <= 2; ++r) {
        const double radius = cylinder->radius_m * r / 2;
        for (int k = -3; k <= 3; ++k) {
          points.push_back(shape.X_LS * Vector3d(radius * std::cos(angle), radius * std::sin(angle),
                                                 k * cylinder->length_m / 6));
        }
      }
    }
  }
  return points;
}

bool inside(const LinkShape& shape, const Vector3d& p_L) {
  const Vector3d p = shape.X_LS.inverse(Eigen::Isometry) * p_L;
  if (const auto* box = std::get_if<BoxShape>(&shape.shape)) {
    return (p.cwiseAbs() - box->size / 2).maxCoeff() < 0;
  }
  const auto* cylinder = std::get_if<CylinderShape>(&shape.shape);
  return cylinder != nullptr && std::hypot(p.x(), p.y()) < cylinder->radius_m &&
         std::abs(p.z()) < cylinder->length_m / 2;
}

class Shapes : public testing::TestWithParam<bool> {
 protected:
  Shapes() {
    for (const Link& link : model_.links) {
      std::vector<Vector3d> points;
      for (const LinkShape& shape : link.collision) {
        const auto more = lattice(shape);
        points.insert(points.end(), more.begin(), more.end());
      }
      points_.push_back(std::move(points));
    }
  }

  /// Names of two links that overlap, empty if none; links `gap` to `far` apart in the chain.
  std::string overlap(const JointVector& q, std::size_t gap, std::size_t far) {
    link_poses(model_, q, X_BL_);
    for (std::size_t a = 0; a < model_.links.size(); ++a) {
      for (std::size_t b = a + gap; b < model_.links.size() && b <= a + far; ++b) {
        if (reaches_into(a, b) || reaches_into(b, a)) {
          return model_.links[a].name + " and " + model_.links[b].name;
        }
      }
    }
    return {};
  }

  bool reaches_into(std::size_t from, std::size_t into) {
    const Isometry3d X = X_BL_[into].inverse(Eigen::Isometry) * X_BL_[from];
    for (const Vector3d& p : points_[from]) {
      const Vector3d p_into = X * p;
      for (const LinkShape& shape : model_.links[into].collision) {
        if (inside(shape, p_into)) return true;
      }
    }
    return false;
  }

  ArmModel model_ = GetParam() ? test::fanuc() : test::motoman();
  std::vector<std::vector<Vector3d>> points_;
  std::vector<Isometry3d> X_BL_{model_.links.size()};
};

TEST_P(Shapes, NextButOneNeverTouchesWithinTheLimits) {
  std::mt19937_64 random{4};
  for (int n = 0; n < 400; ++n) {
    JointVector q = test::random_q(model_, random);
    for (int i = 0; i < model_.dof(); ++i) {  // the corners of the range, too
      const Joint& joint = model_.joints[static_cast<std::size_t>(i)];
      const auto pick = random() % 4;
      if (pick == 0) q(i) = joint.lower_rad;
      if (pick == 1) q(i) = joint.upper_rad;
    }
    ASSERT_EQ(overlap(q, 2, 2), "") << q.transpose();
  }
}

TEST_P(Shapes, NothingTouchesWhileTheToolPointsDownOverTheCell) {
  const bool six = GetParam();
  const auto ik = *make_inverse_kinematics(model_);
  const JointVector home = test::home(model_);
  ASSERT_EQ(overlap(home, 2, 99), "");
  const double tool = six ? 0.194 : 0.30187;
  std::mt19937_64 random{6};
  std::uniform_real_distribution<double> radius(six ? .28 : .42, six ? .6 : .8), azimuth(-1.6, 1.6),
      height(0.0, 0.2), yaw(-1.6, 1.6);
  int reached = 0;
  for (int n = 0; n < 200; ++n) {
    const double r = radius(random), at = azimuth(random);
    Isometry3d X_BF = Isometry3d::Identity();
    X_BF.translation() << r * std::cos(at), r * std::sin(at), height(random) + tool;
    X_BF.linear() = Eigen::AngleAxisd(yaw(random), Vector3d::UnitZ()).toRotationMatrix() *
                    flange_pose(model_, home).linear();
    const auto elbow = ik->choose_elbow(X_BF, home);
    if (!elbow) continue;
    ++reached;
    const auto q = ik->nearest(X_BF, home, *elbow);
    ASSERT_TRUE(q);
    ASSERT_EQ(overlap(*q, 2, 99), "") << q->transpose() << " at " << X_BF.translation().transpose();
  }
  EXPECT_GT(reached, 120);
}

INSTANTIATE_TEST_SUITE_P(Arms, Shapes, testing::Bool(),
                         [](const auto& which) { return which.param ? "fanuc" : "motoman"; });

}  // namespace
}  // namespace aprsim::robot
