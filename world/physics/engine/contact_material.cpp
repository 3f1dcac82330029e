#include "world/physics/engine/contact_material.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::physics {
namespace {

/// Share of a penetration that a step corrects, and normal velocity per normal force.
struct Stiffness {
  double correction, compliance_m_s_n;
};
constexpr Stiffness kPad = {0.2, 1e-5};
constexpr Stiffness kHard = {0.2, 1e-6};
// Spring 1e5 N/m and damper 120 N s/m at 1 ms: a part squeezed between an arm and a table must not
// see the force of an immovable object.
constexpr Stiffness kArm = {0.45, 4.5e-3};

// Velocity per force of sticking friction [m/s per N]. Several contacts hold a part more often than
// needed: where their displacements disagree, friction shares the load. If friction were stiffer
// than fingers on their rails, some contacts of a pad would reach their cones alone.
constexpr double kFrictionCompliance = 5e-8;

constexpr double kMostCorrecting = 0.5;  // [m/s], at which penetration ends
constexpr double kSinkRate = 50;         // [1/s], of the remaining slop
constexpr double kLeastImpact = 0.03;    // [m/s], slower ones give nothing back
constexpr double kLeastAlong = 0.1;  // share of the belt's axis that lies in the contact's plane

/// Speed of rebound by Newton's law of impact, such that from where this step ends the body rises
/// as high as from an impact at the surface: with a = acceleration towards the surface, the
/// semi-implicit Euler steps of a free fall keep I = v^2 / 2 + a x - a h v / 2 at height x, and
/// behind the impact I is e^2 as large. 0 below the least speed of impact, and where the step ends
/// above what the rebound can reach: then it comes down to the surface first, and `unanswered` is
/// what the next step has to answer.
double rebound_m_s(const ContactConstraint& constraint, const ContactSetting& setting,
                   double& unanswered) {
  const double h = setting.flight_step_s, v = setting.normal_speed_m_s;
  const double a = std::max(0.0, -setting.normal_accel_m_s2);
  const double gap = std::max(0.0, -constraint.contact.depth_m);
  const double e = constraint.restitution;
  const bool closes = gap + setting.step_s * (v - setting.step_s * a) <= 0;
  unanswered = 0;
  const double before = constraint.impact_m2_s2;
  if (e <= 0 || !closes || (-v < kLeastImpact && before == 0)) return 0;
  const double I = std::max(before, 0.5 * v * v + a * gap - 0.5 * a * h * v);
  // This step may be a shorter one.
  const double b = a * (setting.step_s - 0.5 * h);
  const double root = b * b + 2 * (e * e * I - a * gap);
  if (root > 0) return std::sqrt(root) - b;
  unanswered = I;
  return 0;
}

}  // namespace

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

ContactResponse contact_response(const ContactConstraint& constraint,
                                 const ContactSetting& setting) {
  const auto& contact = constraint.contact;
  const Stiffness& stiffness = setting.arm_link                        ? kArm
                               : contact.pair == SurfacePair::kPadGear ? kPad
                                                                       : kHard;
  ContactResponse response;
  response.compliance_m_s_n = stiffness.compliance_m_s_n;
  if (!setting.arm_link) {
    response.friction_compliance_m_s_n = kFrictionCompliance;
  }
  // Within the slop a body sinks slowly; by its weight alone, against the soft normal, that would
  // take minutes.
  const double inside = contact.depth_m - penetration_slop_m(contact.pair);
  const double h = setting.step_s;
  const double rate = is_gap(constraint) ? contact.depth_m / h
                      : inside < 0       ? kSinkRate * inside
                                   : std::min(kMostCorrecting, stiffness.correction / h * inside);
  const double rebound = rebound_m_s(constraint, setting, response.unanswered_m2_s2);
  response.target_v_W = rate * contact.n_W;
  response.rebound_m_s = std::max(0.0, rebound - rate);
  if (rebound <= 0) response.rebound_m_s = 0;
  if (!constraint.belt) return response;
  // A surface in motion without a body.
  const Eigen::Vector3d& axis = setting.belt_axis_W;
  const Eigen::Vector3d along = axis - axis.dot(contact.n_W) * contact.n_W;
  // On the belt's end or side it does not move.
  if (along.norm() > kLeastAlong) response.target_v_W += setting.belt_speed_m_s * along;
  return response;
}

}  // namespace aprsim::physics
