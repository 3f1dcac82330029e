#include "world/robot/trajectory/stream/curve_check.hpp"

#include <cmath>
#include <cstdio>
#include <string>

namespace aprsim::robot {
namespace {

constexpr double kRounding = 1 + 1e-9;  ///< of numbers that were converted from other units
constexpr double kAngleRounding_rad = 1e-6;
constexpr int kTorqueSamples = 4;  ///< of a quintic curve, whose acceleration is extreme inside

tl::unexpected<Error> beyond(const ArmModel& model, Eigen::Index joint, const std::string& when,
                             const char* what, double value, double limit, const char* unit) {
  const std::string& name = model.joints[static_cast<std::size_t>(joint)].name;
  char text[200];
  std::snprintf(text, sizeof text, "%s: %s %.6g %s%s, limit %.6g %s", name.c_str(), what, value,
                unit, when.c_str(), limit, unit);
  return fail(ErrorCode::kUnreachable, name, text);
}

tl::unexpected<Error> beyond(const ArmModel& model, Eigen::Index joint, SimTime time,
                             const char* what, double value, double limit, const char* unit) {
  char when[80];
  std::snprintf(when, sizeof when, " before the point at %.6g s", seconds(time));
  return beyond(model, joint, std::string(when), what, value, limit, unit);
}

Result<void> check_extent(const CurveLimits& limits, const JointCurve& curve, SimTime time) {
  const JointLimits& l = limits.joints;
  for (int i = 0; i < limits.model.dof(); ++i) {
    const JointCurve::Extent way = curve.extent(i);
    if (way.lowest < l.lower(i) - kAngleRounding_rad) {
      return beyond(limits.model, i, time, "position", way.lowest, l.lower(i), "rad");
    }
    if (way.highest > l.upper(i) + kAngleRounding_rad) {
      return beyond(limits.model, i, time, "position", way.highest, l.upper(i), "rad");
    }
    if (way.speed > l.speed(i) * kRounding) {
      return beyond(limits.model, i, time, "speed", way.speed, l.speed(i), "rad/s");
    }
  }
  return {};
}

Result<void> check_torque(const CurveLimits& limits, const JointState& state, SimTime time) {
  // The planner's accelerations are possible in every posture: no need for the model's torques.
  if ((state.qdd.array().abs() <= limits.joints.accel.array()).all()) return {};
  const JointVector torque = inverse_dynamics(limits.model, limits.payload, limits.gravity_B,
                                              state.q, state.qd, state.qdd);
  for (Eigen::Index i = 0; i < torque.size(); ++i) {
    const double most = limits.model.joints[static_cast<std::size_t>(i)].max_torque_nm;
    if (std::abs(torque(i)) <= most) continue;
    return beyond(limits.model, i, time, "torque", std::abs(torque(i)), most, "Nm");
  }
  return {};
}

}  // namespace

Result<void> check_curve(const CurveLimits& limits, const CurvePoint& from, const CurvePoint& to) {
  const JointCurve curve(from, to);
  if (auto ok = check_extent(limits, curve, to.time); !ok) return ok;
  if (curve.degree() == 1) return {};
  // The acceleration of a cubic curve is extreme at its ends.
  const int samples = curve.degree() == 3 ? 1 : kTorqueSamples;
  for (int k = 0; k <= samples; ++k) {
    const JointState state = curve.at(curve.duration() * k / samples);
    if (auto ok = check_torque(limits, state, to.time); !ok) return ok;
  }
  return {};
}

Result<void> check_posture(const CurveLimits& limits, const JointVector& q) {
  const JointLimits& l = limits.joints;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const bool low = q(i) < l.lower(i) - kAngleRounding_rad;
    if (!low && q(i) <= l.upper(i) + kAngleRounding_rad) continue;
    return beyond(limits.model, i, std::string(), "position", q(i), low ? l.lower(i) : l.upper(i),
                  "rad");
  }
  return {};
}

}  // namespace aprsim::robot
