#include "world/robot/kinematics/numeric/numeric_ik.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Cholesky>

#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/model/joint_rotation.hpp"

namespace aprsim::robot {
namespace {

constexpr double kWholeTurn = 2 * std::numbers::pi;
constexpr int kStarts = 96;
constexpr int kLockPostures = 16;
constexpr double kNearSeed = 0.35;      ///< a solution this near is the seed's branch [rad, m]
constexpr double kPush = 0.02;          // [rad, m]
constexpr double kSameBranch = 1e-5;    // [rad, m]
constexpr double kPositionWeight = 10;  ///< of a metre against a radian, to rank failures

/// Postures spread over the joint ranges: an additive recurrence with the generalised golden ratio
/// (Roberts 2018); the same on every run.
JointVector spread(const ArmModel& model, int number) {
  const int n = model.dof();
  double ratio = 2;
  for (int i = 0; i < 40; ++i) ratio = std::pow(1 + ratio, 1.0 / (n + 1));
  JointVector q(n);
  double step = 1;
  for (int i = 0; i < n; ++i) {
    step /= ratio;
    const double share = std::fmod(0.5 + step * number, 1.0);
    const Joint& joint = model.joints[static_cast<std::size_t>(i)];
    q(i) = joint.lower_rad + share * (joint.upper_rad - joint.lower_rad);
  }
  return q;
}

/// How well the flange moves while one joint is locked: the smallest pivot of J J^T.
double dexterity_without(const ArmModel& model, int locked, const JointVector& q) {
  Jacobian J = point_jacobian(model, q, model.dof(), Eigen::Vector3d::Zero());
  J.col(locked).setZero();
  const Eigen::Matrix<double, 6, 6> gram = J * J.transpose();
  const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> factor(gram);
  return std::max(0.0, factor.vectorD().minCoeff());
}

std::optional<int> redundant_joint(const ArmModel& model, const std::vector<JointVector>& starts) {
  if (model.dof() < 7) return std::nullopt;
  int best = 0;
  double best_sum = -1;
  for (int joint = 0; joint < model.dof(); ++joint) {
    double sum = 0;
    for (int k = 0; k < kLockPostures; ++k) {
      sum += dexterity_without(model, joint, starts[static_cast<std::size_t>(k)]);
    }
    if (sum > best_sum) {
      best = joint;
      best_sum = sum;
    }
  }
  return best;
}

}  // namespace

NumericIk::NumericIk(const ArmModel& model) : BranchedIk(model), model_(model) {
  for (int k = 0; k < kStarts; ++k) starts_.push_back(spread(model, k));
  locked_ = redundant_joint(model, starts_);
  reach_m_ = flange_offset(model) + longest_offset(model.joints[0]) -
             model.joints[0].X_PJ.translation().norm();
  for (int i = 1; i < dof(); ++i) {
    reach_m_ += longest_offset(model.joints[static_cast<std::size_t>(i)]);
  }
}

/// Position of the locked joint at an elbow angle, with the full turns that bring it near `seed`.
double NumericIk::locked_position(double elbow_rad, double seed) const {
  const Joint& joint = model_.joints[static_cast<std::size_t>(*locked_)];
  if (joint.prismatic) {
    const double share = std::remainder(elbow_rad, kWholeTurn) / kWholeTurn + 0.5;
    return joint.lower_rad + share * (joint.upper_rad - joint.lower_rad);
  }
  return elbow_rad + kWholeTurn * std::round((seed - elbow_rad) / kWholeTurn);
}

double NumericIk::elbow_of(const JointVector& q) const {
  if (!locked_) return 0;
  const Joint& joint = model_.joints[static_cast<std::size_t>(*locked_)];
  if (!joint.prismatic) return std::remainder(q(*locked_), kWholeTurn);
  const double share = (q(*locked_) - joint.lower_rad) / (joint.upper_rad - joint.lower_rad);
  return std::clamp(kWholeTurn * (share - 0.5), -std::numbers::pi, std::numbers::pi);
}

PoseResidual NumericIk::solve(const Eigen::Isometry3d& X_BF, double elbow_rad, bool keep_limits,
                              JointVector& q) const {
  if (locked_) q(*locked_) = locked_position(elbow_rad, q(*locked_));
  return solve_pose({model_, X_BF, locked_, keep_limits}, q);
}

/// The solution near the seed to which a search from it leads, if any.
bool NumericIk::follow(const Eigen::Isometry3d& X_BF, const JointVector& seed, double elbow_rad,
                       JointVector& q) const {
  const auto is_near = [&](const JointVector& found) {
    bool near = true;
    for (int i = 0; i < dof() && near; ++i) {
      near = std::abs(found(i) - seed(i)) < kNearSeed &&
             std::abs(relative_position(i, found(i))) <= 1 + 1e-12;
    }
    return near;
  };
  q = seed;
  const PoseResidual first = solve(X_BF, elbow_rad, true, q);
  if (first.exact && is_near(q)) return true;
  // A search may stop where two branches meet, beside the solution: a push leads on.
  JointVector pushed = seed;
  for (int i = 0; i < dof(); ++i) pushed(i) += i % 2 == 0 ? kPush : -kPush;
  if (solve(X_BF, elbow_rad, true, pushed).exact && is_near(pushed)) {
    q = pushed;
    return true;
  }
  return first.reached && is_near(q);
}

Result<JointVector> NumericIk::nearest(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                       double elbow_rad) const {
  if (X_BF.matrix().allFinite() && seed.allFinite() && std::isfinite(elbow_rad)) {
    JointVector q;
    if (follow(X_BF, seed, elbow_rad, q)) return q;
  }
  return BranchedIk::nearest(X_BF, seed, elbow_rad);
}

void NumericIk::add(const JointVector& q, Branches& out) const {
  for (int b = 0; b < out.count; ++b) {
    bool same = true;
    for (int i = 0; i < dof() && same; ++i) {
      const double apart = q(i) - out.q[static_cast<std::size_t>(b)](i);
      const bool prismatic = model_.joints[static_cast<std::size_t>(i)].prismatic;
      same = std::abs(prismatic ? apart : std::remainder(apart, kWholeTurn)) < kSameBranch;
    }
    if (same) return;
  }
  if (out.count < kMostBranches) out.q[static_cast<std::size_t>(out.count++)] = q;
}

BranchedIk::Branches NumericIk::branches(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                         double elbow_rad) const {
  Branches out;
  const double distance = (X_BF.translation() - model_.joints[0].X_PJ.translation()).norm();
  if (distance > reach_m_) {
    out.excess_m = distance - reach_m_;
    return out;
  }
  search(X_BF, seed, elbow_rad, out);
  return out;
}

/// All exact solutions that the starts lead to, within limits where there are such; else the best
/// one of an arm of few axes; else how the best search fails.
void NumericIk::search(const Eigen::Isometry3d& X_BF, const JointVector& seed, double elbow_rad,
                       Branches& out) const {
  PoseResidual least;
  double least_cost = std::numeric_limits<double>::infinity();
  JointVector best = seed;
  const auto from = [&](JointVector q, bool keep_limits) {
    const PoseResidual residual = solve(X_BF, elbow_rad, keep_limits, q);
    if (residual.exact) return add(q, out);
    const double cost = kPositionWeight * residual.position_m + residual.rotation_rad;
    if (cost >= least_cost) return;
    least_cost = cost;
    least = residual;
    best = q;
  };
  from(seed, true);
  for (const JointVector& start : starts_) from(start, true);
  if (out.count == 0 && least.reached) add(best, out);
  if (out.count > 0) return;
  // Paths to a solution may lead beyond limits. A solution there names the limit in the refusal.
  from(best, false);
  for (const JointVector& start : starts_) from(start, false);
  if (out.count == 0 && least.reached) add(best, out);
  if (least.position_m > kSameBranch || least.rotation_rad == 0) {
    out.excess_m = least.position_m;
  } else {
    out.tilt_rad = least.rotation_rad;
  }
}

api::Posture NumericIk::posture_of(const JointVector& q) const {
  const auto sign = [&q](Eigen::Index joint) { return q(joint) >= 0 ? 1 : -1; };
  return {sign(1), sign(2), sign(q.size() - 2), elbow_of(q)};
}

/// The elbow angle of the posture to which all joints together lead from the seed.
Result<double> NumericIk::choose_elbow(const Eigen::Isometry3d& X_BF,
                                       const JointVector& seed) const {
  if (!locked_) return nearest(X_BF, seed, 0).map([](const JointVector&) { return 0.0; });
  if (X_BF.matrix().allFinite() && seed.allFinite()) {
    JointVector q = seed;
    if (solve_pose({model_, X_BF, std::nullopt, true}, q).reached) return elbow_of(q);
    for (const JointVector& start : starts_) {
      q = start;
      if (solve_pose({model_, X_BF, std::nullopt, true}, q).reached) return elbow_of(q);
    }
  }
  return nearest(X_BF, seed, elbow_of(seed)).map([&](const JointVector& q) { return elbow_of(q); });
}

}  // namespace aprsim::robot
