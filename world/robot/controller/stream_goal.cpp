#include "world/robot/controller/stream_goal.hpp"

#include <cmath>
#include <cstdio>

namespace aprsim::robot {
namespace {

std::string in_words(const Joint& joint, const char* what, double difference, double tolerance,
                     const char* unit) {
  char text[160];
  std::snprintf(text, sizeof text, "%s: %s differs by %.4g %s from the trajectory, tolerance %.4g",
                joint.name.c_str(), what, difference, unit, tolerance);
  return text;
}

}  // namespace

std::string beyond_tolerance(const std::array<api::JointTolerance, api::kMaxJoints>& tolerance,
                             const ArmModel& model, const TrackingState& state) {
  for (Eigen::Index i = 0; i < model.dof(); ++i) {
    const api::JointTolerance& most = tolerance[static_cast<std::size_t>(i)];
    const Joint& joint = model.joints[static_cast<std::size_t>(i)];
    const double position = std::abs(state.q_actual(i) - state.q_desired(i));
    if (most.position_rad > 0 && position > most.position_rad) {
      return in_words(joint, "position", position, most.position_rad, "rad");
    }
    const double velocity = std::abs(state.qd_actual(i) - state.qd_desired(i));
    if (most.velocity_rad_s > 0 && velocity > most.velocity_rad_s) {
      return in_words(joint, "velocity", velocity, most.velocity_rad_s, "rad/s");
    }
  }
  return {};
}

}  // namespace aprsim::robot
