#include "world/physics/physics_world.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "world/physics/divergence_check.hpp"
#include "world/physics/physics_world_impl.hpp"
#include "world/physics/state_hash.hpp"

namespace aprsim::physics {

void PhysicsWorld::Impl::step() {
  ode::prepare_thread();
  cell.belt_speed_m_s = next_belt_speed;
  cell.simplification.begin_step(next_belt_speed);
  move_arms();
  finder.find();
  count_faults();
  solve();
  take_results();
  ++steps;
  check_state(cell, steps);
}

/// What merged bodies ask of their contacts is known when the step has been solved; if some could
/// not bear it, they are freed and the same step is solved anew.
void PhysicsWorld::Impl::solve() {
  const bool merged = cell.simplification.composites().child_count() > 0;
  if (merged) solver.begin();
  solver.step();
  while (merged) {
    released.clear();
    cell.simplification.find_overloaded(released);
    if (released.empty()) return;
    solver.undo();
    finder.release(released);
    solver.begin();
    solver.step();
  }
}

void PhysicsWorld::Impl::move_arms() {
  for (std::size_t r = 0; r < cell.arms.size(); ++r) {
    cell.grippers[r].begin_step(next_mounts[r]);
  }
}

void PhysicsWorld::Impl::count_faults() {
  max_penetration = 0;
  for (const auto& touch : cell.touches) {
    if (cell.nodes.is_link(touch.contact.b)) continue;  // soft on purpose
    max_penetration = std::max(max_penetration, touch.contact.depth_m);
    if (is_fault(touch, cell.nodes)) ++faults;
  }
}

void PhysicsWorld::Impl::take_results() {
  std::erase_if(cell.touches, [](const ContactConstraint& touch) {
    return is_gap(touch) && touch.normal_n == 0;
  });
  for (const int i : cell.simplification.solids()) {
    cell.body(i).refresh();
    cell.simplification.follow(i);
  }
  for (auto& gripper : cell.grippers) gripper.end_step();
  for (auto& arm : cell.arms) arm.end_step();
  observe_grippers();
  for (auto& list : forces) list.clear();
  for (const auto& touch : cell.touches) report_touch(touch);
  arm_contacts.find(forces);
  // What is merged or falls asleep now has still been solved in this step.
  contacts = static_cast<int>(cell.touches.size()) + cell.simplification.frozen_contacts();
  cell.simplification.observe(cell.touches, solver.islands().island_of());
}

void PhysicsWorld::Impl::observe_grippers() {
  for (std::size_t r = 0; r < cell.grippers.size(); ++r) {
    const int robot = static_cast<int>(r);
    PadForces pads;
    std::array<double, 2> hardest{};
    bool touched = false;
    for (const auto& touch : cell.touches) {
      const auto& contact = touch.contact;
      const auto mine = [&](BodyIndex node) {
        return cell.nodes.is_gripper(node) && cell.nodes.robot_of(node) == robot;
      };
      touched = touched || mine(contact.a) || mine(contact.b);
      if (contact.pair != SurfacePair::kPadGear || !mine(contact.a)) continue;
      const int finger = cell.nodes.part_of(contact.a) - 1;
      const auto f = static_cast<std::size_t>(finger);
      const double force = -touch.f_W.dot(cell.grippers[r].closing_W(finger));
      pads.closing_n[f] += force;
      if (force > hardest[f]) {
        hardest[f] = force;
        pads.body[f] = contact.b;
      }
    }
    cell.grippers[r].observe(pads, touched);
  }
}

/// Palm, fingers and what they hold: forces among these are the grip, not a load on the arm.
bool PhysicsWorld::Impl::in_hand(int robot, BodyIndex node) const {
  if (node < 0) return false;
  if (cell.nodes.is_gripper(node)) return cell.nodes.robot_of(node) == robot;
  return cell.grippers[static_cast<std::size_t>(robot)].state().held_body == node;
}

void PhysicsWorld::Impl::report_touch(const ContactConstraint& touch) {
  const auto& contact = touch.contact;
  const auto link_of = [this](BodyIndex node) {
    return cell.nodes.is_link(node) ? cell.nodes.link_of(node) : -1;
  };
  for (std::size_t r = 0; r < cell.arms.size(); ++r) {
    const int robot = static_cast<int>(r);
    const bool a = in_hand(robot, contact.a), b = in_hand(robot, contact.b);
    const int flange = cell.arms[r].links() - 1;
    if (a && !b) {
      forces[r].push_back({flange, contact.p_W, touch.f_W, cell.name_of(contact.b, touch.fixed),
                           link_of(contact.b), true});
    } else if (b && !a) {
      forces[r].push_back(
          {flange, contact.p_W, -touch.f_W, cell.name_of(contact.a, -1), link_of(contact.a), true});
    }
    if (cell.nodes.is_link(contact.b) && cell.nodes.robot_of(contact.b) == robot) {
      forces[r].push_back(
          {cell.nodes.link_of(contact.b), contact.p_W, -touch.f_W, cell.name_of(contact.a, -1)});
    }
  }
}

PhysicsWorld::PhysicsWorld(const scene::Scene& scene, std::span<const robot::ArmModel> models,
                           std::span<const std::vector<Eigen::Isometry3d>> X_WL)
    : impl_(std::make_unique<Impl>(scene, models, X_WL)) {}
PhysicsWorld::~PhysicsWorld() = default;
PhysicsWorld::PhysicsWorld(PhysicsWorld&&) noexcept = default;
PhysicsWorld& PhysicsWorld::operator=(PhysicsWorld&&) noexcept = default;

void PhysicsWorld::set_arm(int robot, std::span<const Eigen::Isometry3d> X_WL_next) {
  const auto r = static_cast<std::size_t>(robot);
  impl_->cell.arms[r].set_next(X_WL_next);
  impl_->next_mounts[r] = X_WL_next.back();
}

void PhysicsWorld::set_gripper_mount(int robot, const Eigen::Isometry3d& X_WF_next) {
  impl_->next_mounts[static_cast<std::size_t>(robot)] = X_WF_next;
}

void PhysicsWorld::set_gripper(int robot, double setting) {
  impl_->cell.grippers[static_cast<std::size_t>(robot)].command(setting);
}

void PhysicsWorld::set_gripper_force(int robot, double force_n) {
  impl_->cell.grippers[static_cast<std::size_t>(robot)].set_force(force_n);
}

void PhysicsWorld::set_belt_speed(double speed_m_s) { impl_->next_belt_speed = speed_m_s; }

void PhysicsWorld::set_velocity(int body, const Eigen::Vector3d& v_com_W,
                                const Eigen::Vector3d& omega_W) {
  auto& simplification = impl_->cell.simplification;
  if (simplification.dormant(body)) simplification.wake(simplification.dormancy().group(body));
  simplification.release(body);
  FreeBody& free = impl_->cell.body(body);
  free.place(free.X_WB, v_com_W, omega_W);
}

void PhysicsWorld::step() { impl_->step(); }

int PhysicsWorld::body_count() const { return static_cast<int>(impl_->cell.bodies.size()); }

BodyState PhysicsWorld::body(int index) const {
  const FreeBody& free = impl_->cell.body(index);
  const auto& simplification = impl_->cell.simplification;
  const Eigen::Isometry3d X_WB = simplification.X_WB(index);
  BodyState state;
  state.p_WB = X_WB.translation();
  state.q_WB = Eigen::Quaterniond(X_WB.linear());
  state.omega_W = free.omega_W;
  state.v_W = simplification.velocity(index) - free.omega_W.cross(X_WB.linear() * free.mass.com);
  state.resting = simplification.resting(index);
  state.group_kind = simplification.group_kind(index);
  state.group = simplification.group(index);
  return state;
}

GripperState PhysicsWorld::gripper(int robot) const {
  return impl_->cell.grippers[static_cast<std::size_t>(robot)].state();
}

std::span<const ArmForce> PhysicsWorld::arm_forces(int robot) const {
  return impl_->forces[static_cast<std::size_t>(robot)];
}

int PhysicsWorld::contact_count() const { return impl_->contacts; }

int PhysicsWorld::virtual_joint_count() const { return impl_->cell.simplification.joint_count(); }

double PhysicsWorld::max_penetration_m() const { return impl_->max_penetration; }

std::uint64_t PhysicsWorld::penetration_faults() const { return impl_->faults; }

std::uint64_t PhysicsWorld::state_hash() const { return physics::state_hash(impl_->cell); }

}  // namespace aprsim::physics
