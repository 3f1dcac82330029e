#include "world/physics/gripper/gripper_constraints.hpp"

namespace aprsim::physics {

void GripperConstraints::add_to(Engine& engine, const std::array<FingerMotion, 2>& motion,
                                const std::array<FingerDrive, 2>& drives,
                                GripperForces& forces) const {
  // The order of joints is fixed: mount, rails with their drives, linkage.
  for (RigidBody& body : bodies_) engine.add_body(body);
  add_mount(engine, forces);
  for (std::size_t i = 0; joints_.fingers && i < 2; ++i) {
    add_finger(engine, i, motion[i], drives[i], forces);
  }
  if (joints_.linkage) add_linkage(engine, forces);
}

/// The palm fixed to the carriage: compliant in translation, stiff in rotation. The axes of its
/// forces are those of the palm: the forces of a rotating hand are then constant, which makes those
/// of the last step good warm starts.
void GripperConstraints::add_mount(Engine& engine, GripperForces& forces) const {
  engine.add_joint(FixedJoint{.a = palm(),
                              .b = carriage_,
                              .R_WJ = palm().R_WB(),
                              .spring = FixedJoint::Spring{joints_.mount_erp, joints_.mount_cfm},
                              .compliance = kStiffCfm,
                              .forces = forces.mount});
}

/// A finger on its rail, with the piston as motor.
void GripperConstraints::add_finger(Engine& engine, std::size_t i, const FingerMotion& motion,
                                    const FingerDrive& drive, GripperForces& forces) const {
  engine.add_joint(SliderJoint{.a = finger(i),
                               .b = palm(),
                               .p_BA = joints_.rail[i],
                               .sign = i == 0 ? -1.0 : 1.0,
                               .travel_m = motion.travel_m,
                               .end_m = joints_.closed_travel_m,
                               .speed_m_s = drive.speed_m_s,
                               .force_n = drive.piston_n,
                               .rail = forces.rail[i],
                               .motor = forces.piston[i],
                               .lower_stop = forces.open_stop[i],
                               .upper_stop = forces.closed_stop[i]});
}

/// The lever on a hinge in the palm, and a rod of constant length from each of its ends to a
/// finger.
void GripperConstraints::add_linkage(Engine& engine, GripperForces& forces) const {
  engine.add_joint(HingeJoint{.a = lever(),
                              .b = palm(),
                              .p_BA = joints_.pivot,
                              .forces = std::span(forces.linkage).first<5>()});
  for (std::size_t i = 0; i < 2; ++i) {
    engine.add_joint(RodJoint{.a = finger(i),
                              .b = lever(),
                              .p_A = joints_.rod_on_finger[i],
                              .p_B = joints_.rod_on_lever[i],
                              .length_m = kRodLength,
                              .force = forces.linkage[5 + i]});
  }
}

}  // namespace aprsim::physics
