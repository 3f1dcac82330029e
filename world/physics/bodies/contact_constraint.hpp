#pragma once

#include "world/physics/bodies/body_ids.hpp"
#include "world/physics/bodies/force_guess.hpp"
#include "world/physics/collision/shapes/contact.hpp"

namespace aprsim::physics {

/// A contact of the present step, with the solver's inputs and results. The first body is always
/// free or a part of a gripper.
struct ContactConstraint {
  Contact contact;
  int fixed = -1;  ///< index of the fixed shape when contact.b is kGround
  double friction = 0;
  double restitution = 0;  ///< see scene::Physics, as the next two
  double rolling_m = 0, spinning_m = 0;
  bool belt = false;
  Eigen::Vector3d f_W = Eigen::Vector3d::Zero();       ///< solved force on contact.a [N]
  double normal_n = 0;                                 ///< its normal part
  Eigen::Vector3d torque_W = Eigen::Vector3d::Zero();  ///< friction's torque on contact.a [Nm]
  /// Warm starts of force and torque: of this step until it is solved, then of the next one.
  ForceGuess<Eigen::Vector3d> f_guess_W{Eigen::Vector3d::Zero()};
  ForceGuess<Eigen::Vector3d> torque_guess_W{Eigen::Vector3d::Zero()};
  double impact_m2_s2 = 0;  ///< energy per mass of an impact that is not answered yet
  /// Displacement of a relative to b along the surfaces since they stuck [m]. Friction undoes it.
  Eigen::Vector3d creep_W = Eigen::Vector3d::Zero();

  /// Whether friction resists rotation as well; torques are 0 otherwise.
  [[nodiscard]] bool has_torsion() const { return rolling_m > 0 || spinning_m > 0; }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [contact, fixed, friction, restitution, rolling_m, spinning_m, belt, f_W, normal_n,
           torque_W, f_guess_W, torque_guess_W, impact_m2_s2, creep_W] = self;
    io(contact, fixed, friction, restitution, rolling_m, spinning_m, belt, f_W, normal_n, torque_W,
       f_guess_W, torque_guess_W, impact_m2_s2, creep_W);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.index_or_none(In::kFixed, fixed);
    in.require(contact.b != kGround || fixed >= 0, "a contact with nothing");
    in.require(friction >= 0 && restitution >= 0, "a friction below 0");
  }
};

inline constexpr std::size_t kConstraintCapacity = 4096;  ///< places to reserve

inline constexpr double kFaultDepth = 0.5e-3;  ///< [m] of penetration: a physics fault

/// A gap that may close in this step.
[[nodiscard]] inline bool is_gap(const ContactConstraint& constraint) {
  return constraint.contact.depth_m < 0;
}

/// Whether the penetration counts as a fault. Contacts with links do not: they are compliant, so
/// that an arm can squeeze a part.
[[nodiscard]] inline bool is_fault(const ContactConstraint& constraint, const BodyIds& ids) {
  return constraint.contact.depth_m > kFaultDepth && !ids.is_link(constraint.contact.b);
}

}  // namespace aprsim::physics
