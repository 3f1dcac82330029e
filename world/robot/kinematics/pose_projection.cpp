#include "world/robot/kinematics/pose_projection.hpp"

#include <algorithm>

#include <Eigen/Cholesky>

#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::robot {
namespace {

constexpr int kMaxSteps = 25;
constexpr double kLongestStep = 0.3;  // [rad]
constexpr double kOnPose = 1e-13;     // [m, rad]
constexpr double kNearPose = 1e-11;   ///< good enough where rounding prevents more
constexpr double kTilt = 1e-4;        ///< that counts as none, of arms of fewer than six axes [rad]
constexpr double kLength_m = 0.4;     ///< that makes lengths comparable with angles

using Twist = Eigen::Matrix<double, 6, 1>;
using TwistMatrix = Eigen::Matrix<double, 6, 6>;

/// From the flange's pose to the target, in base axes; the rotation by its sine.
Twist displacement(const Eigen::Isometry3d& X_BF, const Eigen::Isometry3d& X_BF_target) {
  Twist d;
  d.head<3>() = X_BF_target.translation() - X_BF.translation();
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  // Orientation error as half the sum of cross products of the axes (Siciliano et al. 2009, sec.
  // 3.7.3).
  for (int i = 0; i < 3; ++i) turn += X_BF.linear().col(i).cross(X_BF_target.linear().col(i));
  d.tail<3>() = turn / 2;
  return d;
}

Jacobian scaled_jacobian(const ArmModel& model, const JointVector& q) {
  Jacobian J = point_jacobian(model, q, model.dof(), Eigen::Vector3d::Zero());
  J.topRows<3>() /= kLength_m;
  return J;
}

bool least_norm_step(const Jacobian& J, const Twist& off, JointVector& step) {
  const TwistMatrix gram = J * J.transpose();
  const Eigen::LLT<TwistMatrix> factor(gram);
  if (factor.info() != Eigen::Success) return false;
  step = J.transpose() * factor.solve(off);
  return true;
}

/// For arms of fewer than six axes, which reach the pose only as far as these allow.
bool least_squares_step(const Jacobian& J, const Twist& off, JointVector& step) {
  const JointMatrix normal = J.transpose() * J;
  const Eigen::LLT<JointMatrix> factor(normal);
  if (factor.info() != Eigen::Success) return false;
  step = J.transpose() * off;
  factor.solveInPlace(step);
  return true;
}

}  // namespace

bool project_to_pose(const ArmModel& model, const Eigen::Isometry3d& X_BF, JointVector& q) {
  double last = 1e9;
  const bool few = model.dof() < 6;
  for (int i = 0; i < kMaxSteps; ++i) {
    Twist off = displacement(flange_pose(model, q), X_BF);
    const double distance = off.cwiseAbs().maxCoeff();
    if (distance < kOnPose || (distance < kNearPose && distance >= last)) return true;
    last = distance;
    // dq = J' (J J')^-1 e, the right pseudo-inverse, which moves the joints least (Siciliano et al.
    // 2009, sec. 3.5.1).
    // Least-norm step.
    off.head<3>() /= kLength_m;
    const Jacobian J = scaled_jacobian(model, q);
    JointVector step(model.dof());
    if (!(few ? least_squares_step(J, off, step) : least_norm_step(J, off, step))) return false;
    // Near a singularity J J' is ill-conditioned; the step is limited, and then given up.
    const double longest = step.cwiseAbs().maxCoeff();
    if (!(longest < 1e3)) return false;
    // An arm of few axes is at the nearest of its poses.
    if (few && longest < kNearPose) return distance < kTilt;
    q += longest > kLongestStep ? JointVector(step * (kLongestStep / longest)) : step;
  }
  return false;
}

double dexterity(const ArmModel& model, const JointVector& q) {
  const Jacobian J = scaled_jacobian(model, q);
  if (model.dof() < 6) {
    const JointMatrix normal = J.transpose() * J;
    return std::max(0.0, Eigen::LDLT<JointMatrix>(normal).vectorD().minCoeff());
  }
  const TwistMatrix gram = J * J.transpose();
  // A smallest pivot is cheaper than a smallest singular value, and vanishes with it.
  const Eigen::LDLT<TwistMatrix> factor(gram);
  return std::max(0.0, factor.vectorD().minCoeff());
}

}  // namespace aprsim::robot
