#include "world/robot/trajectory/torque_scaling.hpp"

#include <algorithm>
#include <cmath>

#include "world/robot/trajectory/motion_limits.hpp"

// Dynamic scaling: Hollerbach 1984. The torques of a motion slowed by the factor c are those that
// hold the arm plus c^2 times those that motion adds. Deviation: one factor for the whole motion.

namespace aprsim::robot {
namespace {

constexpr int kSamples = 48;
constexpr double kDifference_s = 1e-3;
constexpr double kSlowest = 0.1;

}  // namespace

double torque_scaling(const ArmModel& model, const Payload& payload,
                      const Eigen::Vector3d& gravity_B, double duration_s,
                      const std::function<JointVector(double)>& position) {
  const JointVector rest = JointVector::Zero(model.dof());
  double square = 1;  // of the scale
  for (int k = 0; k < kSamples; ++k) {
    const double t = duration_s * (k + 0.5) / kSamples;
    const double h = std::min(kDifference_s, duration_s / (2 * kSamples));
    if (!(h > 0)) return 1;
    // Central differences.
    const JointVector before = position(t - h), q = position(t), after = position(t + h);
    const JointVector qd = (after - before) / (2 * h);
    const JointVector qdd = (after - 2 * q + before) / (h * h);
    // Torques that hold the arm, and that motion adds.
    const JointVector hold = inverse_dynamics(model, payload, gravity_B, q, rest, rest);
    const JointVector moving = inverse_dynamics(model, payload, gravity_B, q, qd, qdd) - hold;
    // The scale that leaves the worst drive its share.
    for (int i = 0; i < model.dof(); ++i) {
      const double limit = kTorqueShare * model.joints[static_cast<std::size_t>(i)].max_torque_nm;
      const double room = limit - std::copysign(1.0, moving(i)) * hold(i);
      if (std::abs(moving(i)) * square > room) square = room / std::abs(moving(i));
    }
  }
  return std::sqrt(std::clamp(square, kSlowest * kSlowest, 1.0));
}

}  // namespace aprsim::robot
