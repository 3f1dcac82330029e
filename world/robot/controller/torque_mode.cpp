#include "world/robot/controller/torque_mode.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::robot {
namespace {

constexpr double kSpeedShare = 0.25, kAccelShare = 0.5;  ///< of the joint's limits
/// What a joint meets is at most as stiff as its servo: position gain times velocity gain times
/// inertia. The torque may change by this share of the setting in a step, so that it settles.
constexpr double kServoStiffness_1_s2 = 12000;
constexpr double kTorqueStep = 0.1;
constexpr double kBalance = 0.05;       ///< of the setting
constexpr double kBalanceSpeed = 0.05;  ///< of the free speed
constexpr double kBalanceTime_s = 0.1;

}  // namespace

void TorqueMode::add(const Order& order, double position_rad) {
  Axis& axis = axes_[static_cast<std::size_t>(count_++)];
  axis = {order,
          position_rad,
          0,
          order.rate_nm_s > 0 ? 0.0 : order.torque_nm,
          position_rad == order.target_rad,
          0};
}

bool TorqueMode::settled() const {
  return std::all_of(axes_.begin(), axes_.begin() + count_,
                     [](const Axis& axis) { return axis.there || axis.balanced_steps < 0; });
}

int TorqueMode::balanced_joint() const {
  for (int i = 0; i < count_; ++i) {
    const Axis& axis = axes_[static_cast<std::size_t>(i)];
    if (!axis.there) return axis.order.joint;
  }
  return -1;
}

void TorqueMode::advance(const Surroundings& world, JointVector& q) {
  for (int i = 0; i < count_; ++i) {
    Axis& axis = axes_[static_cast<std::size_t>(i)];
    if (!axis.there) advance(axis, world);
    q(axis.order.joint) = axis.position;
  }
}

void TorqueMode::advance(Axis& axis, const Surroundings& world) const {
  const int j = axis.order.joint;
  const double dt = world.step_s;
  const double setting = axis.order.torque_nm;
  axis.torque = std::min(setting, axis.torque + axis.order.rate_nm_s * dt);
  const double left = axis.order.target_rad - axis.position;
  const double side = left > 0 ? 1 : -1;
  const double against = world.external_nm.size() > 0 ? -side * world.external_nm(j) : 0.0;
  const double free_speed =
      world.speed *
      std::min(kSpeedShare * world.limits.speed(j),
               kTorqueStep * setting / (kServoStiffness_1_s2 * world.inertia(j) * dt));
  const double wanted = free_speed * std::clamp((axis.torque - against) / setting, -1.0, 1.0);
  // Along the side: speeds up with no more than the torque, slows down as fast as the joint may,
  // and in time for the target.
  const double accel = std::min(kAccelShare * world.limits.accel(j), setting / world.inertia(j));
  const double before = side * axis.speed;
  const double speed =
      std::min(std::clamp(wanted, before - world.limits.accel(j) * dt, before + accel * dt),
               std::sqrt(2 * accel * std::abs(left)));
  axis.speed = side * speed;
  axis.position += axis.speed * dt;
  if (side * (axis.order.target_rad - axis.position) <= 0) {
    axis.position = axis.order.target_rad;
    axis.speed = 0;
    axis.there = true;
  }
  if (axis.balanced_steps < 0) return;  // told already
  const bool balanced = axis.torque == setting && free_speed > 0 &&
                        std::abs(against - setting) < kBalance * setting &&
                        std::abs(speed) < kBalanceSpeed * free_speed;
  axis.balanced_steps = balanced ? axis.balanced_steps + 1 : 0;
  if (axis.balanced_steps * dt >= kBalanceTime_s) axis.balanced_steps = -1;
}

JointVector TorqueMode::pressing(int dof) const {
  JointVector torque = JointVector::Zero(dof);
  for (int i = 0; i < count_; ++i) {
    const Axis& axis = axes_[static_cast<std::size_t>(i)];
    if (!axis.there) torque(axis.order.joint) = axis.torque;
  }
  return torque;
}

}  // namespace aprsim::robot
