#include "world/physics/step/physics_step.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "world/physics/bodies/divergence.hpp"
#include "world/physics/bodies/physics_failure.hpp"
#include "world/physics/contacts/suction_search.hpp"

namespace aprsim::physics {
namespace {

constexpr double kBeforePad = 0.7;  // cosine between a pad's direction and that of a contact
// A body whose displacement in a step exceeds kMaxDisplacement moves in substeps of
// kSubstepDisplacement [m].
constexpr double kMaxDisplacement = 6e-3, kSubstepDisplacement = 4.5e-4;
constexpr int kMaxSubsteps = 32;
constexpr int kMaxRechecks = 3;  // after each, the step or substep is solved again

/// Pose at a share of the motion from one pose to another.
Eigen::Isometry3d between_poses(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b,
                                double share) {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  // Spherical linear interpolation (Shoemake 1985), written as a part of the relative rotation.
  const Eigen::AngleAxisd turn(a.linear().transpose() * b.linear());
  out.linear() = a.linear() * Eigen::AngleAxisd(share * turn.angle(), turn.axis()).matrix();
  out.translation() = (1 - share) * a.translation() + share * b.translation();
  return out;
}

}  // namespace

PhysicsStep::PhysicsStep(PhysicsModel& model, BodyPlacement& placement)
    : model_(model),
      placement_(placement),
      search_(model),
      solver_(model),
      recheck_(model, search_, solver_),
      penalty_(model),
      report_(model) {
  unmerged_.reserve(model.bodies.size());
  reached_.reserve(model.bodies.size());
  substep_contacts_.reserve(kConstraintCapacity);
  for (const ArmLinks& arm : model.arms) {
    auto& links = next_links_.emplace_back();
    for (int i = 0; i < arm.links(); ++i) links.push_back(arm.X_WL(i));
    next_mounts_.push_back(links.back());
    between_.reserve(links.size());
  }
}

/// A step in which a fast body hits something is divided into substeps: after the impact the body
/// departs in directions that were not searched, and rotates far.
void PhysicsStep::run() {
  results_.max_penetration_m = 0;
  search_.cache().begin_step();
  solver_.begin_step(results_.count);
  report_.begin_step();
  const int substeps = substep_count();
  substeps > 1 ? run_substeps(substeps) : run_substep(1);
  report_.end_step(penalty_);
  ++results_.count;
  // One body's failure is that body's loss: the others go on.
  placement_.lose_bodies(results_.count);
  check_grippers();
}

/// A gripper cannot be lost. A state that is caught here has not reached contact search yet; the
/// caller keeps the last good one.
void PhysicsStep::check_grippers() const {
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    // Idle grippers are moved by kinematics alone.
    if (model_.grippers[r].idle()) continue;
    for (const RigidBody& body : model_.grippers[r].bodies()) {
      if (!has_diverged(body.motion())) continue;
      throw PhysicsFailure("step " + std::to_string(results_.count) + ": the motion of robot " +
                           model_.scene.robots[r].name + "'s gripper has diverged");
    }
  }
}

void PhysicsStep::run_substeps(int substeps) {
  model_.set_step_s(model_.scene.physics.step_s / substeps);
  for (std::size_t r = 0; r < model_.arms.size(); ++r) {
    for (std::size_t i = 0; i < next_links_[r].size(); ++i) {
      next_links_[r][i] = model_.arms[r].X_WL_next(static_cast<int>(i));
    }
  }
  for (int left = substeps; left > 0; --left) run_substep(left);
  model_.set_step_s(model_.scene.physics.step_s);
  // The step's contacts are those of all substeps, with mean forces over the step.
  std::swap(model_.constraints, substep_contacts_);
  substep_contacts_.clear();
}

/// Substeps for fast bodies only: their rotation and the change of contact points within a step are
/// not small, so that speculative contacts alone would let them pass.
int PhysicsStep::substep_count() const {
  double longest = 0;
  for (const int i : model_.simplification.awake()) {
    if (model_.is_held(i)) continue;  // as fast as a robot
    if (model_.displacement_m(i) > kMaxDisplacement)
      longest = std::max(longest, max_displacement_m(i));
  }
  if (longest <= kMaxDisplacement) return 1;
  const double further = std::ceil((longest - kMaxDisplacement) / kSubstepDisplacement);
  return 1 + static_cast<int>(std::min<double>(kMaxSubsteps - 1, further));
}

/// Largest displacement of a body in the coming step relative to anything that it may touch; 0 if
/// there is nothing.
double PhysicsStep::max_displacement_m(int body) const {
  const FreeBody& own = model_.body(body);
  const BodyVelocity own_velocity{own.com_W(), own.v_com_W, own.omega_W, own.radius_m};
  double longest = 0;
  const auto include = [&](const Aabb& box, const Eigen::Vector3d& p_W, const Eigen::Vector3d& v_W,
                           const Eigen::Vector3d& omega_W) {
    if (!own.bounds.meets(box)) return;
    const Displacement relative = relative_displacement(
        own_velocity, {.p_W = p_W, .v_W = v_W, .omega_W = omega_W}, model_.step_s);
    longest = std::max(longest, relative.max_m());
  };
  const Eigen::Vector3d still = Eigen::Vector3d::Zero();
  const Eigen::Vector3d belt_W = model_.belt_speed_m_s * model_.fixed.belt_axis_W;
  for (const StaticShape& shape : model_.fixed.shapes) {
    include(shape.bounds, still, shape.belt ? belt_W : still, still);
  }
  for (const int other : model_.simplification.awake()) {
    const FreeBody& it = model_.body(other);
    if (other != body) include(it.bounds, it.com_W(), it.v_com_W, it.omega_W);
  }
  const auto& sleeping = model_.simplification.sleeping();
  for (const int group : sleeping.groups()) {
    include(sleeping.box(group), still, sleeping.velocity(sleeping.first(group)), still);
  }
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    const GripperMechanism& gripper = model_.grippers[r];
    const Eigen::Vector3d p_W = next_mounts_[r].translation();
    include(gripper.parts().bounds(), p_W, gripper.mount_velocity(p_W), gripper.mount_omega());
    if (!model_.arms[r].shapes().empty()) include(model_.arms[r].bounds(), still, still, still);
  }
  return longest;
}

/// Kinematics first, then contacts at the present poses, then forces and velocities from these
/// (semi-implicit Euler). `left`: remaining substeps, this one included.
void PhysicsStep::run_substep(int left) {
  begin_substep(left);
  // Order within a step: contacts, suction from the gaps under the lips, statistics, solution, new
  // poses.
  search_.find();
  find_suction(model_);
  count_faults();
  solve();
  collect_results(left);
}

/// Inputs for the end of the step are approached in equal substeps.
void PhysicsStep::begin_substep(int left) {
  const double share = 1.0 / left;
  model_.belt_speed_m_s = left == 1
                              ? next_belt_speed_m_s_
                              : (1 - share) * model_.belt_speed_m_s + share * next_belt_speed_m_s_;
  // Groups that the new belt speed disturbs wake before contacts are searched, and so take part in
  // this step.
  model_.simplification.begin_step(model_.belt_speed_m_s);
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    GripperMechanism& gripper = model_.grippers[r];
    gripper.begin_step(left == 1 ? next_mounts_[r]
                                 : between_poses(gripper.X_WF(), next_mounts_[r], share));
    if (share_of_step() < 1) begin_arm(r, left);
  }
}

void PhysicsStep::begin_arm(std::size_t robot, int left) {
  ArmLinks& arm = model_.arms[robot];
  between_.clear();
  for (std::size_t i = 0; i < next_links_[robot].size(); ++i) {
    const Eigen::Isometry3d& X_WL = arm.X_WL(static_cast<int>(i));
    between_.push_back(left == 1 ? next_links_[robot][i]
                                 : between_poses(X_WL, next_links_[robot][i], 1.0 / left));
  }
  arm.set_next(between_);
}

/// Counts before the solve: depths are those that the last substep left.
void PhysicsStep::count_faults() {
  for (const auto& constraint : model_.constraints) {
    if (model_.ids.is_link(constraint.contact.b)) continue;  // soft on purpose
    results_.max_penetration_m = std::max(results_.max_penetration_m, constraint.contact.depth_m);
    if (is_fault(constraint, model_.ids)) ++results_.penetration_faults;
  }
}

/// The wrenches that merged bodies require of their contacts are known after the solve. Bodies
/// whose wrench is outside its cone are unmerged, and the same step is solved again.
void PhysicsStep::solve() {
  const bool merged = model_.simplification.composites().child_count() > 0;
  const bool may_impact = recheck_.may_impact();
  // The state before the step is only saved if the step may have to be undone.
  if (merged || may_impact) solver_.begin();
  apply_suction(model_);
  solver_.step();
  recheck_.begin();
  for (int i = 0; may_impact && i < kMaxRechecks && recheck_.add_new_contacts(); ++i) {
    apply_suction(model_);
    solver_.solve_again(recheck_.known_contacts());
  }
  // Every round frees at least one body, so it ends.
  // Trial step (see design/physics.md): solve with merged bodies rigid, then test each contact
  // wrench against its friction cone.
  while (merged) {
    unmerged_.clear();
    model_.simplification.find_overstressed(unmerged_);
    if (unmerged_.empty()) return;
    solver_.undo();
    search_.unmerge(unmerged_);
    solver_.begin();
    apply_suction(model_);
    solver_.step();
  }
}

void PhysicsStep::collect_results(int left) {
  // Gaps that did not close.
  // A speculative contact without impulse is not a touch and must not be reported as one.
  std::erase_if(model_.constraints, [](const ContactConstraint& constraint) {
    return is_gap(constraint) && constraint.normal_n == 0;
  });
  for (const int i : model_.simplification.awake_roots()) {
    model_.body(i).refresh();
    model_.simplification.move_members(i);
  }
  // Poses of everything else follow the solved velocities. Members of composites follow their root.
  for (auto& gripper : model_.grippers) gripper.end_step();
  for (auto& arm : model_.arms) arm.end_step();
  for (std::size_t r = 0; left == 1 && r < model_.grippers.size(); ++r) {
    observe_gripper(static_cast<int>(r));
  }
  const double share = share_of_step();
  report_.add_substep(share);
  if (share < 1) keep_substep_contacts(share);
  // Bodies that merge or fall asleep now have still been solved in this step.
  results_.contact_count =
      static_cast<int>(model_.constraints.size()) + model_.simplification.frozen_count();
  model_.simplification.observe(model_.constraints, solver_.islands().resting_together());
}

/// Keeps the contacts of a substep, with their share of the mean forces over the step.
void PhysicsStep::keep_substep_contacts(double share) {
  for (ContactConstraint constraint : model_.constraints) {
    // Sensors and reports see the mean force over the whole step: each substep contributes its
    // impulse over h.
    constraint.f_W *= share;
    constraint.normal_n *= share;
    substep_contacts_.push_back(constraint);
  }
}

/// The pads' forces on gears and trays, each summed up over the contacts of its pad.
void PhysicsStep::observe_gripper(int robot) {
  GripperMechanism& gripper = model_.grippers[static_cast<std::size_t>(robot)];
  PadForces pads;
  bool touched = false;
  for (const auto& constraint : model_.constraints) {
    const auto& contact = constraint.contact;
    const auto mine = [&](BodyIndex id) {
      return model_.ids.is_gripper(id) && model_.ids.robot_of(id) == robot;
    };
    touched = touched || mine(contact.a) || mine(contact.b);
    if (!mine(contact.a) || !model_.ids.is_part(contact.b)) continue;
    const int finger = model_.ids.part_of(contact.a) - 1;
    if (finger < 0 || gripper.cup()) continue;
    const Eigen::Vector3d closing_W = gripper.parts().closing_W(finger);
    // A tray meets the whole finger; only what is before the pad is between the fingers.
    const bool pad = contact.pair == SurfacePair::kPadGear;
    if (!pad && -contact.n_W.dot(closing_W) < kBeforePad) continue;
    const auto f = static_cast<std::size_t>(finger);
    const double force = -constraint.f_W.dot(closing_W);
    pads.closing_n[f] += force;
    if (force > pads.body_n[f]) {
      pads.body_n[f] = force;
      pads.body[f] = contact.b;
    }
  }
  pads.joined = are_joined(pads.body[0], pads.body[1]);
  gripper.observe(pads, touched);
}

/// Whether two bodies are one, or a chain of free bodies that press each other leads from one to
/// the other.
bool PhysicsStep::are_joined(int first, int second) {
  if (first < 0 || second < 0 || first == second) return first >= 0 && first == second;
  reached_.assign(model_.bodies.size(), 0);
  reached_[static_cast<std::size_t>(first)] = 1;
  for (bool grows = true; grows;) {
    grows = false;
    for (const auto& constraint : model_.constraints) {
      const auto& contact = constraint.contact;
      if (constraint.normal_n <= 0 || !model_.ids.is_part(contact.a) ||
          !model_.ids.is_part(contact.b)) {
        continue;
      }
      char &a = reached_[static_cast<std::size_t>(contact.a)],
           &b = reached_[static_cast<std::size_t>(contact.b)];
      grows = grows || a != b;
      a = b = static_cast<char>(a | b);
    }
  }
  return reached_[static_cast<std::size_t>(second)] != 0;
}

// ---- keeping a state

PhysicsStep::State PhysicsStep::save() const {
  return {search_.cache().save(), solver_.save(), report_.save(), next_belt_speed_m_s_, results_};
}

void PhysicsStep::restore(const State& state) {
  search_.cache().restore(state.cache);
  solver_.restore(state.solver);
  report_.restore(state.forces);
  next_belt_speed_m_s_ = state.next_belt_speed_m_s;
  results_ = state.results;
}

void PhysicsStep::adopt(const PhysicsStep& old, const ContactReport::State& forces) {
  report_.restore(forces);
  next_mounts_ = old.next_mounts_;
  next_belt_speed_m_s_ = old.next_belt_speed_m_s_;
  results_ = old.results_;
}

}  // namespace aprsim::physics
