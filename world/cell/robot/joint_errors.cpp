#include "world/cell/robot/joint_errors.hpp"

#include <algorithm>

namespace aprsim::world {
namespace {

/// An injected error of an encoder comes and goes at this speed.
constexpr double kErrorSpeed_rad_s = 0.2;

/// A value on its way to another, by at most `most`.
double towards(double value, double goal, double most) {
  return value + std::clamp(goal - value, -most, most);
}

bool not_zero(double value) { return value != 0; }

}  // namespace

void JointErrors::begin(const RobotFaults& faults) {
  any_ = any_ || std::ranges::any_of(faults.backlash_rad, not_zero) ||
         std::ranges::any_of(faults.encoder_bias_rad, not_zero);
}

void JointErrors::step(const robot::JointVector& q, const RobotFaults& faults, double step_s) {
  if (!any_) return;
  if (q_before_.size() == 0) q_before_ = q;
  const double most = kErrorSpeed_rad_s * step_s;
  bool any = false;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    double& half = half_width_rad_[at];
    half = towards(half, 0.5 * faults.backlash_rad[at], most);
    double& play = play_rad_[at];
    play = std::clamp(play - (q(i) - q_before_(i)), -half, half);
    double& bias = bias_rad_[at];
    bias = towards(bias, faults.encoder_bias_rad[at], most);
    any = any || half != 0 || bias != 0 || faults.backlash_rad[at] != 0 ||
          faults.encoder_bias_rad[at] != 0;
  }
  q_before_ = q;
  any_ = any;
  if (!any) q_before_.resize(0);
}

robot::JointVector JointErrors::links_at(const robot::JointVector& q) const {
  robot::JointVector out = q;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    out(i) += play_rad_[at] - bias_rad_[at];
  }
  return out;
}

}  // namespace aprsim::world
