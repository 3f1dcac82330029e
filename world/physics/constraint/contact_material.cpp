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

constexpr double kSinking = 20;  // [1/s]

/// Depth up to which nothing pushes back [m], so that what rests keeps its contacts: it sinks in by
/// this much. Trays are shoved, and need more. What pads squeeze keeps its contacts anyway, and
/// within a layer it could stick off centre.
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

dContact ode_contact(const ContactConstraint& touch, bool soft, const Eigen::Vector3d& belt_axis_W,
                     double belt_speed_m_s, const Eigen::Vector3d& slide_W) {
  const auto& contact = touch.contact;
  dContact out = {};
  ode::copy(contact.p_W, out.geom.pos);
  ode::copy(contact.n_W, out.geom.normal);
  const double inside = contact.depth_m - penetration_slop_m(contact.pair);
  out.geom.depth = std::max(0.0, inside);

  auto& surface = out.surface;
  const Softness& softness = soft ? kArm : contact.pair == SurfacePair::kPadGear ? kPad : kHard;
  surface.mode = dContactSoftERP | dContactSoftCFM | dContactApprox1;
  surface.soft_erp = softness.erp;
  surface.soft_cfm = softness.cfm;
  surface.mu = touch.friction;
  if (inside < 0) {  // or it would take its weight minutes to press it in
    surface.mode |= dContactMotionN;
    surface.motionN = kSinking * inside;
  }
  if (!slide_W.isZero()) {
    surface.mode |= dContactFDir1;
    ode::copy(slide_W.normalized(), out.fdir1);
  }
  if (touch.belt) {
    const Eigen::Vector3d along = belt_axis_W - belt_axis_W.dot(contact.n_W) * contact.n_W;
    if (along.norm() > 0.1) {
      const Eigen::Vector3d t1 = (slide_W.isZero() ? along : slide_W).normalized();
      const Eigen::Vector3d v_belt_W = belt_speed_m_s * along;
      surface.mode |= dContactFDir1 | dContactMotion1 | dContactMotion2;
      surface.motion1 = v_belt_W.dot(t1);
      surface.motion2 = v_belt_W.dot(contact.n_W.cross(t1));
      ode::copy(t1, out.fdir1);
    }
  }
  return out;
}

}  // namespace aprsim::physics
