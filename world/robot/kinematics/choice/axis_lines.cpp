#include "world/robot/kinematics/choice/axis_lines.hpp"

#include <cmath>
#include <cstddef>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::robot {
namespace {

constexpr int kCheckedPostures = 8;
constexpr double kMovesAlike = 1e-8;  // [m, rad]

/// Different postures on every call, the same on every run.
JointVector posture(const ArmModel& model, int number) {
  JointVector q(model.dof());
  for (int i = 0; i < model.dof(); ++i) q(i) = 2.5 * std::sin(1.7 * number + 2.3 * i + 0.4);
  return q;
}

}  // namespace

std::vector<AxisLine> axis_lines(const ArmModel& model) {
  std::vector<AxisLine> lines;
  Eigen::Isometry3d X_BL = Eigen::Isometry3d::Identity();
  for (const Joint& joint : model.joints) {
    X_BL = X_BL * joint.X_PJ;
    lines.push_back({X_BL.linear() * joint.axis, X_BL.translation()});
  }
  return lines;
}

bool are_parallel(const AxisLine& a, const AxisLine& b) {
  return a.direction.cross(b.direction).norm() < kLineTolerance;
}

bool are_orthogonal(const AxisLine& a, const AxisLine& b) {
  return std::abs(a.direction.dot(b.direction)) < kLineTolerance;
}

/// Least squares: the sum of the projectors normal to the lines.
std::optional<Eigen::Vector3d> meeting_point(std::initializer_list<AxisLine> lines) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const AxisLine& line : lines) {
    const Eigen::Matrix3d normal =
        Eigen::Matrix3d::Identity() - line.direction * line.direction.transpose();
    A += normal;
    b += normal * line.point;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(A, Eigen::EigenvaluesOnly);
  if (solver.eigenvalues()(0) < 1e-3) return std::nullopt;
  const Eigen::Vector3d point = A.inverse() * b;
  for (const AxisLine& line : lines) {
    if (line.direction.cross(point - line.point).norm() > kLineTolerance) return std::nullopt;
  }
  return point;
}

void CanonicalArm::add(const Eigen::Vector3d& axis, const Eigen::Vector3d& offset, double sign,
                       double zero, bool prismatic) {
  Joint joint;
  joint.prismatic = prismatic;
  joint.axis = axis;
  joint.X_PJ.translation() = offset;
  chain_.joints.push_back(joint);
  chain_.links.resize(chain_.joints.size() + 1);
  sign_.push_back(sign);
  zero_.push_back(zero);
}

std::optional<Placement> CanonicalArm::match(const ArmModel& model,
                                             const Eigen::Isometry3d& X_BA) const {
  const int n = model.dof();
  Placement out;
  out.X_BA = X_BA;
  out.sign = Eigen::Map<const Eigen::VectorXd>(sign_.data(), n);
  out.offset = Eigen::Map<const Eigen::VectorXd>(zero_.data(), n);
  const Eigen::Isometry3d X_BE = X_BA * flange_pose(chain_, out.offset);
  out.X_EF = X_BE.inverse() * flange_pose(model, JointVector::Zero(n));
  for (int k = 0; k < kCheckedPostures; ++k) {
    const JointVector q = posture(model, k);
    const Eigen::Isometry3d X_BF = X_BA * flange_pose(chain_, out.family(q)) * out.X_EF;
    const double apart = (X_BF.matrix() - flange_pose(model, q).matrix()).cwiseAbs().maxCoeff();
    if (!(apart < kMovesAlike)) return std::nullopt;
  }
  return out;
}

}  // namespace aprsim::robot
