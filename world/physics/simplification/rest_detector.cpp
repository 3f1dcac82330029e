#include "world/physics/simplification/rest_detector.hpp"

namespace aprsim::physics {
namespace {

constexpr int kMergeSteps = 20;  // at rest relative to each other before two are merged
constexpr int kRestSteps = 20;   // at rest on the carrier before it counts
constexpr int kSleepSteps = 40;  // before a group falls asleep
constexpr double kShare = 0.1;   // of e1 and e2: stricter than the paper's criteria
constexpr double kDrift = 2e-8;  // [m] over all of that time

/// Distance between two poses of a body of that radius: at most that of any of its points, within a
/// factor of about two.
double drift(const Eigen::Isometry3d& now, const Eigen::Isometry3d& then, double radius_m) {
  return (now.translation() - then.translation()).norm() +
         (now.linear() - then.linear()).norm() * radius_m;
}

}  // namespace

RestDetector::RestDetector(const scene::Physics& physics, std::span<const FreeBody> bodies)
    : speed_(kShare * physics.simplify_speed_m_s),
      accel_(kShare * physics.simplify_accel_m_s2),
      step_s_(physics.step_s),
      bodies_(bodies),
      rest_(bodies.size()) {}

void RestDetector::count_on_carrier(int i, const CarrierMotion& carrier, bool disturbed) {
  const bool rests = at_rest_on_carrier(i, carrier);
  at(i).carrier_steps = rests && !disturbed ? at(i).carrier_steps + 1 : 0;
}

bool RestDetector::at_rest_on_carrier(int i, const CarrierMotion& carrier) {
  Rest& rest = at(i);
  const FreeBody& free = body(i);
  // Relative to the carrier, so that a tray on a running belt is at rest (the paper's criterion is
  // relative, too).
  const Eigen::Vector3d v = free.v_com_W - carrier.v_W;
  const Eigen::Vector3d v_before = rest.v_before - carrier.v_before_W;
  Eigen::Isometry3d now = free.X_WB;
  now.translation() -= carrier.travel_W;
  if (rest.carrier_steps == 0) rest.on_carrier = now;
  // Slow creep restarts the count, but is still reported as rest.
  if (rest.carrier_steps > kRestSteps && drift(now, rest.on_carrier, free.radius_m) > kDrift) {
    rest.carrier_steps = kRestSteps;
    rest.on_carrier = now;
  }
  // Rotation counts at the body's radius: the paper bounds the velocity of the centre only.
  return v.norm() < speed_ && free.omega_W.norm() * free.radius_m < speed_ &&
         (v - v_before).norm() < accel_ * step_s_;
}

bool RestDetector::resting(int i) const { return at(i).carrier_steps >= kRestSteps; }

bool RestDetector::may_sleep(int i) const { return at(i).carrier_steps >= kSleepSteps; }

bool RestDetector::count_on_body(int child, int support) {
  Rest& rest = at(child);
  rest.pair_steps = at_rest_on_body(child, support) ? rest.pair_steps + 1 : 0;
  return rest.pair_steps >= kMergeSteps;
}

bool RestDetector::at_rest_on_body(int child, int support) {
  Rest& rest = at(child);
  const FreeBody& upper = body(child);
  const FreeBody& lower = body(support);
  // A body on a turning carrier has the velocity of the carrier's material point, not of its
  // centre.
  // Velocities relative to the lower body's point at the upper one's centre of mass.
  const Eigen::Vector3d lever = upper.com_W() - lower.com_W();
  const Eigen::Vector3d v = upper.v_com_W - lower.v_com_W - lower.omega_W.cross(lever);
  const Eigen::Vector3d v_before =
      rest.v_before - at(support).v_before - at(support).omega_before.cross(lever);
  const Eigen::Vector3d spin = upper.omega_W - lower.omega_W;
  const bool slow = v.norm() < speed_ && spin.norm() * upper.radius_m < speed_ &&
                    (v - v_before).norm() < accel_ * step_s_;
  if (!slow) return false;
  const Eigen::Isometry3d X = lower.X_WB.inverse() * upper.X_WB;
  if (rest.pair_steps == 0) rest.in_support = X;
  return drift(X, rest.in_support, upper.radius_m) < kDrift;
}

Eigen::Vector3d RestDetector::accel_W(int i) const {
  return (body(i).v_com_W - at(i).v_before) / step_s_;
}

Eigen::Vector3d RestDetector::alpha_W(int i) const {
  return (body(i).omega_W - at(i).omega_before) / step_s_;
}

void RestDetector::end_step(int i) {
  at(i).v_before = body(i).v_com_W;
  at(i).omega_before = body(i).omega_W;
}

void RestDetector::wake(int i, const Eigen::Vector3d& v_W) {
  Rest& rest = at(i);
  // A woken body still counts as resting until it moves, so that readings do not flicker.
  rest.carrier_steps = kRestSteps;
  rest.pair_steps = 0;
  rest.v_before = v_W;
  rest.omega_before.setZero();
}

}  // namespace aprsim::physics
