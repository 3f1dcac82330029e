#pragma once

#include <random>
#include <stdexcept>
#include <string>

#include "world/robot/model/arm_model.hpp"

namespace aprsim::robot::test {

inline constexpr double kDegree = 0.017453292519943295;  ///< [rad]
inline constexpr double kServoStep = 1e-3;               ///< [s]

inline ArmModel load(const std::string& name) {
  auto model = load_arm_model(std::string(APRSIM_SOURCE_DIR) + "/world/models/" + name + ".urdf");
  if (!model) throw std::runtime_error(model.error().message);
  return *model;
}

inline ArmModel fanuc() { return load("fanuc_lrmate200id"); }
inline ArmModel motoman() { return load("motoman_sia20"); }

/// Uniform within `fraction` of the limits.
inline JointVector random_q(const ArmModel& model, std::mt19937_64& random, double fraction = 1) {
  JointVector q(model.dof());
  for (int i = 0; i < model.dof(); ++i) {
    const Joint& joint = model.joints[static_cast<std::size_t>(i)];
    const double mid = (joint.lower_rad + joint.upper_rad) / 2;
    const double half = fraction * (joint.upper_rad - joint.lower_rad) / 2;
    q(i) = std::uniform_real_distribution<double>(mid - half, mid + half)(random);
  }
  return q;
}

inline JointVector home(const ArmModel& model) {
  JointVector q = JointVector::Zero(model.dof());
  const double quarter = 1.5707963267948966;
  if (model.dof() == 6) {
    q(4) = -quarter;
  } else {
    q(3) = -quarter;
    q(5) = -quarter;
  }
  return q;
}

inline double angle_between(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) {
  // From the sine for small angles: the trace alone would lose half the digits.
  const Eigen::Matrix3d D = A.transpose() * B;
  const Eigen::Vector3d axis(D(2, 1) - D(1, 2), D(0, 2) - D(2, 0), D(1, 0) - D(0, 1));
  return std::atan2(axis.norm() / 2, (D.trace() - 1) / 2);
}

}  // namespace aprsim::robot::test
