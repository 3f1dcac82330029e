#include "world/physics/gripper/gripper_bodies.hpp"

#include <algorithm>

#include "world/physics/bodies/mass_properties.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Vector3d;

constexpr double kLeverShare = 0.2;  // of a finger's mass

}  // namespace

GripperBodies::GripperBodies(const scene::Gripper& gripper, const scene::Physics& physics,
                             const GripperParts& open)
    : palm_stiffness_n_m_(gripper.palm_stiffness_n_m),
      palm_damping_ns_m_(gripper.palm_damping_ns_m),
      relaxation_(gripper.palm_relaxation),
      relaxation_s_(gripper.palm_relaxation_s),
      gravity_W_(0, 0, -physics.gravity_m_s2) {
  joints_.fingers = !gripper.cup;
  joints_.linkage = joints_.fingers && gripper.law == scene::GripperLaw::kLinkage;
  joints_.closed_travel_m = 0.5 * (gripper.gap_open_m - gripper.gap_closed_m);
  set_step_s(physics.step_s);
  const std::array<double, 4> kg = {gripper.palm_mass_kg, gripper.finger_mass_kg,
                                    gripper.finger_mass_kg, kLeverShare * gripper.finger_mass_kg};
  for (std::size_t i = 0; i < all().size(); ++i) {
    const GripperPart& part = open.part(static_cast<int>(i));
    bodies_[i].set_mass(kg[i], box_inertia(kg[i], part.size));
    bodies_[i].set_ballistic(false);
    bodies_[i].set_orientation(Eigen::Matrix3d(part.X_WS.linear()));
    bodies_[i].set_position(part.X_WS.translation());
  }
  carried_v_W_.fill(Vector3d::Zero());
  for (std::size_t i = 0; joints_.fingers && i < 2; ++i) make_rail(i, open);
  if (joints_.linkage) make_linkage(open);
}

/// Finger on palm, positive travel closing.
void GripperBodies::make_rail(std::size_t i, const GripperParts& open) {
  const int finger = static_cast<int>(i);
  joints_.rail[i] = open.part(finger + 1).X_TS.translation() - open.part(0).X_TS.translation();
  rails_[i] = FingerRail(bodies_[i + 1], bodies_[0], open.closing_W(finger));
}

/// A lever on the palm, turning about the tool's axis, with a rod to each finger. Lever ends and
/// rods are mirror images through the pivot, so equal travels are exact.
void GripperBodies::make_linkage(const GripperParts& open) {
  // A lever longer than the travel keeps its rotation small, and so the rods nearly in line with
  // the rails.
  const double arm = std::max(0.02, 2 * joints_.closed_travel_m);
  joints_.pivot =
      open.part(GripperParts::kLever).X_TS.translation() - open.part(0).X_TS.translation();
  for (std::size_t i = 0; i < 2; ++i) {
    const double side = i == 0 ? 1 : -1;
    joints_.rod_on_lever[i] = side * arm * Vector3d::UnitX();
    joints_.rod_on_finger[i] = joints_.pivot + joints_.rod_on_lever[i] +
                               side * GripperConstraints::kRodLength * Vector3d::UnitY() -
                               joints_.rail[i];
  }
}

/// The mount is the implicit spring and damper of ODE's manual, section "How to use ERP and CFM".
void GripperBodies::set_step_s(double step_s) {
  step_s_ = step_s;
  // ERP = h k / (h k + d) and CFM = 1 / (h k + d): implicit Euler of a spring k with damper d.
  const double hk = step_s_ * palm_stiffness_n_m_;
  joints_.mount_erp = hk / (hk + palm_damping_ns_m_);
  joints_.mount_cfm = 1 / (hk + palm_damping_ns_m_);
}

std::array<FingerMotion, 2> GripperBodies::finger_motion() const {
  if (!joints_.fingers) return {};
  return {rails_[0].motion(bodies_[1], bodies_[0]), rails_[1].motion(bodies_[2], bodies_[0])};
}

void GripperBodies::follow(const GripperParts& parts, const MountMotion& mount) {
  relaxed_S_.setZero();
  for (std::size_t i = 0; i < all().size(); ++i) {
    const Eigen::Isometry3d& X_WS = parts.part(static_cast<int>(i)).X_WS;
    bodies_[i].set_orientation(Eigen::Matrix3d(X_WS.linear()));
    bodies_[i].set_position(X_WS.translation());
    carried_v_W_[i] = mount.velocity_at(X_WS.translation(), step_s_);
    bodies_[i].set_velocity(carried_v_W_[i], mount.omega_W);
  }
}

/// Velocities relative to the carriage rotate with it. The arm bears the carriage's own
/// acceleration; along the rails the fingers' inertia and weight load the pistons.
void GripperBodies::begin_step(const GripperParts& parts, const MountMotion& mount,
                               const Vector3d& omega_before_W) {
  relax(parts, mount);
  for (std::size_t i = 0; i < all().size(); ++i) {
    RigidBody& body = bodies_[i];
    const int part = static_cast<int>(i);
    // d'Alembert along the rails only: the arm bears all other weight and inertia of the gripper,
    // so that a free swing of the robot does not deflect it.
    const Vector3d u = mount.velocity_at(parts.part(part).X_WS.translation(), step_s_);
    const Vector3d before = mount.delta.linear() * carried_v_W_[i];
    Vector3d next = u + mount.delta.linear() * body.v_W() - before;
    if (joints_.fingers && (i == 1 || i == 2)) {
      const Vector3d axis = parts.closing_W(part - 1);
      next += axis.dot(step_s_ * gravity_W_ - (u - before)) * axis;
    }
    body.set_velocity(next,
                      mount.omega_W + mount.delta.linear() * (body.omega_W() - omega_before_W));
    carried_v_W_[i] = u;
  }
}

/// A Maxwell element beside the spring: the mount's rest position approaches a share of the palm's
/// deflection, so that the force at a held deflection falls from k d to (1 - share) k d.
void GripperBodies::relax(const GripperParts& parts, const MountMotion& mount) {
  if (relaxation_ == 0) return;
  const Eigen::Isometry3d X_WS = parts.palm_at(mount.X_WT);
  const Vector3d deflection_S = X_WS.linear().transpose() * (bodies_[0].p_W() - X_WS.translation());
  relaxed_S_ += std::min(1.0, step_s_ / relaxation_s_) * (relaxation_ * deflection_S - relaxed_S_);
}

void GripperBodies::add_to(Engine& engine, const GripperParts& parts, const MountMotion& mount,
                           const std::array<FingerMotion, 2>& motion,
                           const std::array<FingerDrive, 2>& drives) {
  place_carriage(parts, mount);
  for (std::size_t i = 0; joints_.fingers && i < 2; ++i) {
    if (drives[i].extra_n != 0)
      rails_[i].apply_force(bodies_[i + 1], bodies_[0], drives[i].extra_n);
  }
  GripperConstraints(joints_, moved(), carriage_).add_to(engine, motion, drives, forces_);
}

/// At the palm's centre, so that the mount sees no lever arm; its velocity takes it to its next
/// pose in this step.
void GripperBodies::place_carriage(const GripperParts& parts, const MountMotion& mount) {
  const Eigen::Isometry3d X_WS = parts.palm_at(mount.X_WT);
  carriage_.set_orientation(Eigen::Matrix3d(X_WS.linear()));
  // Unchanged bits without relaxation: x + 0 would turn -0 into 0.
  carriage_.set_position(relaxation_ == 0 ? Vector3d(X_WS.translation())
                                          : Vector3d(X_WS * relaxed_S_));
  carriage_.set_velocity(mount.velocity_at(X_WS.translation(), step_s_), mount.omega_W);
}

void GripperBodies::save(Solved& to) const {
  for (std::size_t i = 0; i < all().size(); ++i) to.bodies[i] = bodies_[i].motion();
  to.forces = forces_;
}

void GripperBodies::restore(const Solved& from) {
  for (std::size_t i = 0; i < all().size(); ++i) bodies_[i].restore(from.bodies[i]);
  forces_ = from.forces;
}

GripperBodies::State GripperBodies::save() const {
  State state;
  save(state.solved);
  state.carried_v_W = carried_v_W_;
  state.relaxed_S = relaxed_S_;
  return state;
}

void GripperBodies::restore(const State& state) {
  restore(state.solved);
  carried_v_W_ = state.carried_v_W;
  relaxed_S_ = state.relaxed_S;
}

}  // namespace aprsim::physics
