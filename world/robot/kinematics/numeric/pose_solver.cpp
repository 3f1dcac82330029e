#include "world/robot/kinematics/numeric/pose_solver.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "world/robot/kinematics/branched_ik.hpp"
#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::robot {
namespace {

constexpr int kSteps = 60;
constexpr double kLongestMotion = 0.6;  ///< of a joint in one step [rad, m]
constexpr double kExact = 1e-13;        ///< no step can improve on it [m, rad]
/// Exact is wider for few axes: poses from a wire are rounded out of those that the axes allow.
constexpr double kReached = 1e-9, kExactForFewAxes = 1e-8, kReachedByFewAxes_m = 1e-7;
constexpr double kLeastDamping = 1e-9, kMostDamping = 1e6;
/// Weight of a metre against a radian. An arm of few axes gives up orientation, not position.
constexpr double kWeight = 2.5, kWeightOfFewAxes = 250;

using Twist = Eigen::Matrix<double, 6, 1>;

class Search {
 public:
  Search(const PoseProblem& problem, const JointVector& start)
      : problem_(problem),
        few_(problem.model.dof() < 6),
        weight_(few_ ? kWeightOfFewAxes : kWeight),
        q_(start) {}

  PoseResidual run() {
    error_ = error_at(q_);
    double damping = 1;
    for (int i = 0; i < kSteps && error_.cwiseAbs().maxCoeff() > kExact; ++i) {
      if (step(damping)) {
        damping = std::max(damping * 0.2, kLeastDamping);
      } else {
        damping *= 5;
        if (damping > kMostDamping) break;
      }
    }
    return residual();
  }

  [[nodiscard]] const JointVector& q() const { return q_; }

 private:
  /// Weighted distance to the target, rotation as a rotation vector in base axes.
  [[nodiscard]] Twist error_at(const JointVector& q) const {
    const Eigen::Isometry3d X_BF = flange_pose(problem_.model, q);
    Twist error;
    error.head<3>() = weight_ * (problem_.X_BF.translation() - X_BF.translation());
    const Eigen::Matrix3d R = problem_.X_BF.linear() * X_BF.linear().transpose();
    // From the sine for small angles, where the trace loses half the digits.
    const Eigen::Vector3d sine(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
    const double length = sine.norm();
    const double angle = std::atan2(length, R.trace() - 1);
    if (length > 1e-9) {
      error.tail<3>() = sine * (angle / length);
    } else if (angle < 1) {
      error.tail<3>() = sine / 2;
    } else {
      error.tail<3>() = Eigen::AngleAxisd(R).axis() * angle;  // half a turn
    }
    return error;
  }

  /// One damped step. The damping falls with the squared error (Sugihara 2011), which makes the
  /// last steps those of Gauss and Newton. False where it does not help.
  bool step(double damping) {
    Jacobian J = point_jacobian(problem_.model, q_, problem_.model.dof(), Eigen::Vector3d::Zero());
    J.topRows<3>() *= weight_;
    const JointVector gradient = J.transpose() * error_;
    for (int i = 0; i < q_.size(); ++i) {
      if (problem_.locked == i || pushes_outwards(i, gradient(i))) J.col(i).setZero();
    }
    const double before = error_.squaredNorm();
    JointMatrix normal = J.transpose() * J;
    normal.diagonal().array() += damping * before + 1e-14;
    JointVector motion = J.transpose() * error_;
    normal.llt().solveInPlace(motion);
    const double longest = motion.cwiseAbs().maxCoeff();
    if (longest > kLongestMotion) motion *= kLongestMotion / longest;
    JointVector q = q_ + motion;
    if (problem_.keep_limits) clamp(q);
    const Twist error = error_at(q);
    if (!(error.squaredNorm() < before)) return false;
    q_ = q;
    error_ = error;
    return true;
  }

  [[nodiscard]] bool pushes_outwards(int i, double gradient) const {
    if (!problem_.keep_limits) return false;
    const Joint& joint = problem_.model.joints[static_cast<std::size_t>(i)];
    return (q_(i) <= joint.lower_rad && gradient < 0) || (q_(i) >= joint.upper_rad && gradient > 0);
  }

  void clamp(JointVector& q) const {
    for (int i = 0; i < q.size(); ++i) {
      if (problem_.locked == i) continue;
      const Joint& joint = problem_.model.joints[static_cast<std::size_t>(i)];
      q(i) = std::clamp(q(i), joint.lower_rad, joint.upper_rad);
    }
  }

  [[nodiscard]] PoseResidual residual() const {
    PoseResidual out;
    out.position_m = error_.head<3>().norm() / weight_;
    out.rotation_rad = error_.tail<3>().norm();
    const double exact = few_ ? kExactForFewAxes : kReached;
    out.exact = out.position_m < exact && out.rotation_rad < exact;
    out.reached = few_ ? out.position_m < kReachedByFewAxes_m &&
                             out.rotation_rad < BranchedIk::kTiltTolerance_rad
                       : out.exact;
    return out;
  }

  const PoseProblem& problem_;
  bool few_;
  double weight_;
  JointVector q_;
  Twist error_;
};

}  // namespace

PoseResidual solve_pose(const PoseProblem& problem, JointVector& q) {
  Search search(problem, q);
  const PoseResidual residual = search.run();
  q = search.q();
  return residual;
}

}  // namespace aprsim::robot
