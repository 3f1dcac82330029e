#include "world/physics/gripper/gripper_mechanism.hpp"

#include <algorithm>

namespace aprsim::physics {

GripperMechanism::GripperMechanism(const scene::Gripper& gripper, const scene::Physics& physics,
                                   const Eigen::Isometry3d& X_WF)
    : gap_open_m_(gripper.gap_open_m),
      actuator_(gripper),
      mount_(MountMotion::at_rest(X_WF)),
      parts_(gripper, X_WF),
      bodies_(gripper, physics, parts_) {
  if (gripper.cup) cup_.emplace(*gripper.cup);
  report_.separation_m = gap_open_m_;
  report_.X_WT = Pose::from(mount_.X_WT);
  follow_mount();
}

// ---- tool change

void GripperMechanism::attach(const Eigen::Isometry3d& X_WF, const Eigen::Isometry3d& X_FT) {
  mounted_ = true;
  X_FT_ = X_FT;
  mount_ = MountMotion::at_rest(X_WF * X_FT);
  idle_ = true;
  report_.X_WT = Pose::from(mount_.X_WT);
  report_.palm_deflection_m = 0;
  follow_mount();
  if (cup_) return actuator_.is_closing() ? wake() : void();
  // A gripper may be idle only where it would rest without being solved.
  const bool at_stop = std::ranges::all_of(
      motion_, [this](const FingerMotion& finger) { return finger.travel_m == stop_travel_m(); });
  if (!at_stop || !actuator_.is_at_full_force()) wake();
}

void GripperMechanism::detach() {
  // The lever has no commanded travel, so that its pose on the tool is the only record of it.
  if (!idle_) parts_.hold_lever(mount_.X_WT);
  mounted_ = false;
  idle_ = true;
  for (FingerMotion& motion : motion_) motion.rate_m_s = 0;
  actuator_.vent();
  vent_cup();
  grasp_.restart(report_);
  report_.force_n = {};
  report_.holding = false;
  report_.held_body = -1;
  report_.settled = true;
  report_.palm_deflection_m = 0;
  follow_mount();
}

// ---- commands

void GripperMechanism::command(double setting) {
  // A repeated command changes nothing, and must not restart the settling time.
  if (!mounted_ || !actuator_.command(setting)) return;  // no air without a mount
  grasp_.restart(report_);
  wake();
}

void GripperMechanism::set_force(double force_n) {
  if (mounted_ && actuator_.set_force(force_n)) wake();
}

void GripperMechanism::set_wear(const GripperWear& wear) {
  if (actuator_.set_wear(wear)) wake();
}

// ---- keeping a state

GripperMechanism::State GripperMechanism::save() const {
  return {.parts = parts_.save(),
          .bodies = bodies_.save(),
          .actuator = actuator_.save(),
          .cup = cup_ ? cup_->save() : SuctionCup::State{},
          .mounted = mounted_,
          .X_FT = X_FT_,
          .mount = mount_,
          .motion = motion_,
          .drives = drives_,
          .idle = idle_,
          .grasp = grasp_,
          .report = report_};
}

void GripperMechanism::restore(const State& state) {
  parts_.restore(state.parts);
  bodies_.restore(state.bodies);
  actuator_.restore(state.actuator);
  if (cup_) cup_->restore(state.cup);
  mounted_ = state.mounted;
  X_FT_ = state.X_FT;
  mount_ = state.mount;
  motion_ = state.motion;
  drives_ = state.drives;
  idle_ = state.idle;
  grasp_ = state.grasp;
  report_ = state.report;
}

// ---- a step

void GripperMechanism::begin_step(const Eigen::Isometry3d& X_WF_next) {
  const Eigen::Vector3d omega_before_W = mount_.omega_W;
  // The arm is not part of the contact solver. Its flange is a kinematic input, and contact forces
  // return to it as loads.
  mount_.begin_step(X_WF_next * X_FT_, bodies_.step_s());
  if (idle_) return;
  bodies_.begin_step(parts_, mount_, omega_before_W);
  if (cup_) return;
  motion_ = bodies_.finger_motion();
  // Forces of the drive use the fingers' motion before the step (semi-implicit).
  drives_ = actuator_.advance(motion_, bodies_.closed_travel_m(), bodies_.step_s());
}

void GripperMechanism::wake() {
  if (!mounted_) return;
  grasp_.stay_awake();
  if (!idle_) return;
  idle_ = false;
  parts_.place_lever(mount_.X_WT);
  // While idle only the parts moved; the bodies resume at their poses and velocities.
  bodies_.follow(parts_, mount_);
}

bool GripperMechanism::has_suction() const {
  return cup_ && mounted_ && cup_->has_suction(actuator_.is_closing());
}

void GripperMechanism::advance_suction(const LipSeal& seal, int body, double share) {
  cup_->advance(actuator_.is_closing(), seal, body, share, bodies_.step_s());
  report_.vacuum_pa = cup_->vacuum_pa();
  if (!cup_->is_steady()) grasp_.restart(report_);
}

void GripperMechanism::vent_cup() {
  report_.vacuum_pa = 0;
  if (cup_) cup_->vent();
}

void GripperMechanism::add_to(Engine& engine) {
  bodies_.add_to(engine, parts_, mount_, motion_, drives_);
}

void GripperMechanism::end_step() {
  mount_.end_step();
  if (idle_) {
    follow_mount();
  } else {
    read_from_bodies();
  }
  report_.X_WT = Pose::from(parts_.X_WT());
}

/// Parts and readings from the bodies.
void GripperMechanism::read_from_bodies() {
  const auto bodies = bodies_.all();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    parts_.place(i, bodies[i].R_WB(), bodies[i].p_W());
  }
  if (cup_) {
    parts_.place_cup();
  } else {
    motion_ = bodies_.finger_motion();
    for (std::size_t i = 0; i < 2; ++i) report_.travel_m[i] = motion_[i].travel_m;
  }
  report_.separation_m = gap_open_m_ - report_.travel_m[0] - report_.travel_m[1];
  report_.palm_deflection_m =
      (parts_.part(0).X_WS.translation() - parts_.palm_at(mount_.X_WT).translation()).norm();
}

/// Idle: the parts move with the mount as one.
void GripperMechanism::follow_mount() {
  if (mounted_) {
    parts_.follow(mount_.X_WT, report_.travel_m);
  } else {
    parts_.follow_removed(mount_.X_WT, report_.travel_m);
  }
}

void GripperMechanism::observe(const PadForces& pads, bool touched) {
  report_.force_n = pads.closing_n;
  if (idle_) return;
  if (cup_ ? observe_cup(touched) : observe_fingers(pads, touched)) become_idle();
}

bool GripperMechanism::observe_fingers(const PadForces& pads, bool touched) {
  return grasp_.observe({.pads = pads,
                         .motion = motion_,
                         .stop_travel_m = stop_travel_m(),
                         .closed_travel_m = bodies_.closed_travel_m(),
                         .force_n = actuator_.force_n(),
                         .at_full_force = actuator_.is_at_full_force(),
                         .touched = touched},
                        report_);
}

/// The monitor sees a gripper whose pads press with the suction's force.
bool GripperMechanism::observe_cup(bool touched) {
  const Suction suction = cup_->suction();
  const PadForces pads{.closing_n = {suction.force_n, suction.force_n},
                       .body = {suction.body, suction.body},
                       .joined = suction.body >= 0};
  report_.force_n = {suction.force_n, 0};
  // The same monitor serves cups: suction force stands for the forces of both pads.
  return grasp_.observe({.pads = pads,
                         .motion = motion_,
                         .stop_travel_m = 0,
                         .closed_travel_m = 1,
                         .force_n = cup_->full_force_n(),
                         .at_full_force = cup_->is_steady(),
                         .touched = touched || has_suction()},
                        report_);
}

/// Sets the fingers exactly to the stop and the palm to the mount. The lever keeps its pose.
void GripperMechanism::become_idle() {
  const double stop = cup_ ? 0 : stop_travel_m();
  idle_ = true;
  report_.travel_m = {stop, stop};
  report_.separation_m = gap_open_m_ - 2 * stop;
  report_.palm_deflection_m = 0;
  motion_ = {FingerMotion{stop, 0}, FingerMotion{stop, 0}};
  parts_.hold_lever(mount_.X_WT);
  follow_mount();
}

BodyVelocity GripperMechanism::part_velocity(int part) const {
  const GripperPart& box = parts_.part(part);
  BodyVelocity out{.p_W = box.X_WS.translation(), .reach_m = 0.5 * box.size.norm()};
  if (idle_) {
    out.v_W = mount_velocity(out.p_W);
    out.omega_W = mount_.omega_W;
  } else {
    const RigidBody& body = bodies_.of_part(part);
    out.omega_W = body.omega_W();
    out.v_W = body.velocity_at(out.p_W);
  }
  return out;
}

}  // namespace aprsim::physics
