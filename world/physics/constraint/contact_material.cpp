#include "world/physics/constraint/contact_material.hpp"

#include <algorithm>

#include "world/physics/bodies/ode_handles.hpp"

namespace aprsim::physics {
namespace {

struct Softness {
  double erp, cfm;
};
constexpr Softness kPad = {0.2, 1e-5};
constexpr Softness kHard = {0.2, 1e-6};
// Spring 1e5 N/m and damper 120 N s/m at 1 ms: a part squeezed between an arm and a table must not
// see the force of an immovable object.
constexpr Softness kArm = {0.45, 4.5e-3};

constexpr double kSinkRate = 20;     // [1/s], of the remaining slop
constexpr double kLeastAlong = 0.1;  // share of the belt's axis that lies in the contact's plane

/// Penetration slop: resting bodies keep this depth, and with it their contacts. Trays are shoved,
/// and need more. What pads squeeze keeps its contacts anyway, and within a slop it could stick off
/// centre.
double penetration_slop_m(SurfacePair pair) {
  switch (pair) {
    case SurfacePair::kPadGear:
      return 0;
    case SurfacePair::kTrayBelt:
    case SurfacePair::kTrayGround:
    case SurfacePair::kTrayTray:
      return 1e-5;
    default:
      return 2e-6;
  }
}

}  // namespace

ContactResponse contact_response(const ContactConstraint& constraint, bool arm_link,
                                 const Eigen::Vector3d& belt_axis_W, double belt_speed_m_s,
                                 const Eigen::Vector3d& slide_W) {
  const auto& contact = constraint.contact;
  const Softness& softness = arm_link ? kArm : contact.pair == SurfacePair::kPadGear ? kPad : kHard;
  ContactResponse response;
  response.erp = softness.erp;
  response.cfm = softness.cfm;
  // Within the slop a body sinks slowly; by its weight alone, against the soft normal, that would
  // take minutes.
  const double inside = contact.depth_m - penetration_slop_m(contact.pair);
  response.depth_m = std::max(0.0, inside);
  if (inside < 0) response.approach_m_s = kSinkRate * inside;
  if (!slide_W.isZero()) {
    response.directed = true;
    response.axis_W = slide_W.normalized();
  }
  if (!constraint.belt) return response;
  // The belt's velocity, split along both axes of friction: a body-less surface in motion.
  const Eigen::Vector3d along = belt_axis_W - belt_axis_W.dot(contact.n_W) * contact.n_W;
  if (along.norm() <= kLeastAlong) return response;  // on the belt's end or side
  const Eigen::Vector3d t1 = (slide_W.isZero() ? along : slide_W).normalized();
  const Eigen::Vector3d v_belt_W = belt_speed_m_s * along;
  response.directed = response.belt = true;
  response.axis_W = t1;
  response.belt_m_s = v_belt_W.dot(t1);
  response.belt_across_m_s = v_belt_W.dot(contact.n_W.cross(t1));
  return response;
}

dContact ode_contact(const ContactConstraint& constraint, const ContactResponse& response) {
  dContact out = {};
  ode::copy(constraint.contact.p_W, out.geom.pos);
  ode::copy(constraint.contact.n_W, out.geom.normal);
  out.geom.depth = response.depth_m;
  auto& surface = out.surface;
  surface.mode = dContactSoftERP | dContactSoftCFM | dContactApprox1;
  surface.soft_erp = response.erp;
  surface.soft_cfm = response.cfm;
  surface.mu = constraint.friction;
  if (response.approach_m_s < 0) {
    surface.mode |= dContactMotionN;
    surface.motionN = response.approach_m_s;
  }
  if (response.directed) {
    surface.mode |= dContactFDir1;
    ode::copy(response.axis_W, out.fdir1);
  }
  if (response.belt) {
    surface.mode |= dContactMotion1 | dContactMotion2;
    surface.motion1 = response.belt_m_s;
    surface.motion2 = response.belt_across_m_s;
  }
  return out;
}

}  // namespace aprsim::physics
