#include "world/physics/ode/ode_contact.hpp"

#include <algorithm>

#include "world/physics/engine/contact_material.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Vector3d;

constexpr double kSlides = 1e-4;  // [m/s]

void copy(const Vector3d& from, dReal* to) { std::copy_n(from.data(), 3, to); }

Vector3d velocity_at(const RigidBody* body, const Vector3d& p_W) {
  return body == nullptr ? Vector3d::Zero() : body->velocity_at(p_W);
}

/// Depth beyond the slop by the ERP of the world. Gaps, and links of arms, which are springs on
/// purpose, by a target velocity.
void set_normal(const ContactConstraint& constraint, const ContactSetting& setting,
                const ContactResponse& response, dContact& contact) {
  const double inside = constraint.contact.depth_m - penetration_slop_m(constraint.contact.pair);
  if (response.rebound_m_s > 0) {
    contact.surface.mode |= dContactBounce;
    contact.surface.bounce = constraint.restitution;
    contact.surface.bounce_vel = 0;
  } else if (is_gap(constraint) || setting.arm_link) {
    contact.surface.mode |= dContactMotionN;
    contact.surface.motionN = response.target_v_W.dot(constraint.contact.n_W);
  } else {
    contact.geom.depth = std::max(0.0, inside);
  }
  if (!setting.arm_link) return;
  contact.surface.mode |= dContactSoftCFM;
  contact.surface.soft_cfm = response.compliance_m_s_n;
}

/// The friction of a sliding contact has the size of Coulomb's only along an edge of the pyramid.
void set_friction(const RigidBody* a, const RigidBody* b, const ContactConstraint& constraint,
                  const Vector3d& surface_v_W, dContact& contact) {
  const Vector3d &p = constraint.contact.p_W, &n = constraint.contact.n_W;
  contact.surface.mu = contact.surface.mu2 = constraint.friction;
  Vector3d slip = velocity_at(a, p) - velocity_at(b, p) - surface_v_W;
  slip -= slip.dot(n) * n;
  const Vector3d& along = slip.norm() > kSlides ? slip : surface_v_W;
  if (along.norm() > kSlides) {
    const Vector3d edge = along.normalized();
    contact.surface.mode |= dContactFDir1 | dContactMotion1 | dContactMotion2;
    copy(edge, contact.fdir1);
    contact.surface.motion1 = surface_v_W.dot(edge);
    contact.surface.motion2 = surface_v_W.dot(n.cross(edge));
  }
  if (!constraint.has_torsion()) return;
  contact.surface.mode |= dContactRolling;
  contact.surface.rho = contact.surface.rho2 = constraint.rolling_m;
  contact.surface.rhoN = constraint.spinning_m;
}

}  // namespace

dContact ode_contact(const RigidBody* a, const RigidBody* b, const ContactConstraint& constraint,
                     const ContactSetting& setting) {
  const ContactResponse response = contact_response(constraint, setting);
  const Vector3d& n = constraint.contact.n_W;
  dContact contact{};
  contact.surface.mode = dContactApprox1 | dContactMu2;
  copy(constraint.contact.p_W, contact.geom.pos);
  copy(n, contact.geom.normal);
  set_normal(constraint, setting, response, contact);
  set_friction(a, b, constraint, response.target_v_W - response.target_v_W.dot(n) * n, contact);
  return contact;
}

}  // namespace aprsim::physics
