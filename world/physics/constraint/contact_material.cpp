#include "world/physics/constraint/contact_material.hpp"

#include <algorithm>

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

constexpr double kMostCorrecting = 0.5;  // [m/s], at which penetration ends
constexpr double kSinkRate = 20;         // [1/s], of the remaining slop
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
                                 double step_s) {
  const auto& contact = constraint.contact;
  const Softness& softness = arm_link ? kArm : contact.pair == SurfacePair::kPadGear ? kPad : kHard;
  ContactResponse response;
  response.cfm = softness.cfm;
  // Within the slop a body sinks slowly; by its weight alone, against the soft normal, that would
  // take minutes.
  const double inside = contact.depth_m - penetration_slop_m(contact.pair);
  const double rate = is_gap(constraint) ? contact.depth_m / step_s
                      : inside < 0       ? kSinkRate * inside
                                   : std::min(kMostCorrecting, softness.erp / step_s * inside);
  response.target_v_W = rate * contact.n_W;
  if (!constraint.belt) return response;
  // A surface in motion without a body.
  const Eigen::Vector3d along = belt_axis_W - belt_axis_W.dot(contact.n_W) * contact.n_W;
  // On the belt's end or side it does not move.
  if (along.norm() > kLeastAlong) response.target_v_W += belt_speed_m_s * along;
  return response;
}

}  // namespace aprsim::physics
