#include "world/physics/physics_world.hpp"

#include "world/physics/model/body_placement.hpp"
#include "world/physics/model/physics_model.hpp"
#include "world/physics/model/tool_changes.hpp"
#include "world/physics/state/adoption.hpp"
#include "world/physics/step/physics_step.hpp"
#include "world/physics/step/state_hash.hpp"

namespace aprsim::physics {

struct PhysicsWorld::Impl {
  Impl(const scene::Scene& scene, std::span<const robot::ArmModel> arm_models,
       std::span<const std::vector<Eigen::Isometry3d>> X_WL)
      : model(scene, arm_models, X_WL), placement(model), step(model, placement) {}

  [[nodiscard]] GripperMechanism& gripper(int robot) {
    return model.grippers[static_cast<std::size_t>(robot)];
  }

  PhysicsModel model;
  BodyPlacement placement;
  PhysicsStep step;
};

PhysicsWorld::PhysicsWorld(const scene::Scene& scene, std::span<const robot::ArmModel> arm_models,
                           std::span<const std::vector<Eigen::Isometry3d>> X_WL)
    : impl_(std::make_unique<Impl>(scene, arm_models, X_WL)) {}
PhysicsWorld::~PhysicsWorld() = default;
PhysicsWorld::PhysicsWorld(PhysicsWorld&&) noexcept = default;
PhysicsWorld& PhysicsWorld::operator=(PhysicsWorld&&) noexcept = default;

// ---- a step

void PhysicsWorld::set_arm(int robot, std::span<const Eigen::Isometry3d> X_WL_next) {
  impl_->model.arms[static_cast<std::size_t>(robot)].set_next(X_WL_next);
  // The gripper's mount follows the flange. A tool changer may override it afterwards, in the same
  // step.
  impl_->step.set_mount(robot, X_WL_next.back());
}

void PhysicsWorld::set_gripper_mount(int robot, const Eigen::Isometry3d& X_WF_next) {
  impl_->step.set_mount(robot, X_WF_next);
}

void PhysicsWorld::set_gripper(int robot, double setting) {
  impl_->gripper(robot).command(setting);
}

void PhysicsWorld::set_gripper_force(int robot, double force_n) {
  impl_->gripper(robot).set_force(force_n);
}

void PhysicsWorld::set_gripper_wear(int robot, const GripperWear& wear) {
  impl_->gripper(robot).set_wear(wear);
}

void PhysicsWorld::set_belt_speed(double speed_m_s) { impl_->step.set_belt_speed(speed_m_s); }

void PhysicsWorld::step() { impl_->step.run(); }

void PhysicsWorld::advance_clock(std::uint64_t steps) { impl_->step.advance_clock(steps); }

// ---- between two steps

void PhysicsWorld::attach_tool(int robot, int tool, const Eigen::Isometry3d& X_WF) {
  physics::attach_tool(impl_->model, robot, tool, X_WF);
  impl_->step.set_mount(robot, X_WF);
}

void PhysicsWorld::detach_tool(int robot) { physics::detach_tool(impl_->model, robot); }

void PhysicsWorld::set_velocity(int body, const Eigen::Vector3d& v_com_W,
                                const Eigen::Vector3d& omega_W) {
  impl_->placement.set_velocity(body, v_com_W, omega_W);
}

void PhysicsWorld::add_impulse(int body, const Eigen::Vector3d& impulse_W,
                               const Eigen::Vector3d& angular_W) {
  impl_->placement.add_impulse(body, impulse_W, angular_W);
}

void PhysicsWorld::set_decoupled_from_belt(int body, bool decoupled_from_belt) {
  impl_->placement.set_decoupled_from_belt(body, decoupled_from_belt);
}

void PhysicsWorld::place(std::span<const Placement> placements) {
  impl_->placement.place(placements);
}

void PhysicsWorld::remove(int body) { impl_->placement.remove(body, impl_->step.results().count); }

PhysicsState PhysicsWorld::save() const { return {impl_->model, impl_->step}; }

void PhysicsWorld::restore(const State& state) { state.restore(impl_->model, impl_->step); }

void PhysicsWorld::adopt(const PhysicsWorld& old, std::span<const int> old_of) {
  physics::adopt(impl_->model, impl_->step, old.impl_->model, old.impl_->step, old_of);
}

// ---- results

int PhysicsWorld::body_count() const { return impl_->model.ids.part_count(); }

BodyState PhysicsWorld::body(int index) const { return body_state(impl_->model, index); }

int PhysicsWorld::tool_count() const { return static_cast<int>(impl_->model.tools.size()); }

BodyState PhysicsWorld::tool(int index) const { return tool_state(impl_->model, index); }

int PhysicsWorld::tool_of(int robot) const {
  return impl_->model.tool_of_robot[static_cast<std::size_t>(robot)];
}

double PhysicsWorld::opening(int tool) const {
  return impl_->model.mechanism(tool).state().separation_m;
}

GripperState PhysicsWorld::gripper(int robot) const {
  GripperState state = impl_->gripper(robot).state();
  // A tool that a cup holds has no number among the bodies.
  if (!impl_->model.ids.is_part(state.held_body)) state.held_body = -1;
  return state;
}

std::span<const ArmForce> PhysicsWorld::arm_forces(int robot) const {
  return impl_->step.report().arm_forces(robot);
}

int PhysicsWorld::contact_count() const { return impl_->step.results().contact_count; }

void PhysicsWorld::write_contacts(std::vector<api::ContactSnapshot>& out) const {
  impl_->step.report().write(out);
}

const ContactPairs& PhysicsWorld::contact_pairs() const { return impl_->step.report().pairs(); }

std::uint64_t PhysicsWorld::grouping_version() const {
  return impl_->model.simplification.changes();
}

BodyGrouping PhysicsWorld::grouping(int id) const {
  return impl_->model.simplification.grouping(id);
}

bool PhysicsWorld::lost(int id) const { return impl_->model.body(id).lost_step.has_value(); }

std::vector<std::string> PhysicsWorld::fixed_names() const {
  std::vector<std::string> names;
  for (const StaticShape& shape : impl_->model.fixed.shapes) names.emplace_back(shape.name);
  return names;
}

int PhysicsWorld::virtual_joint_count() const { return impl_->model.simplification.joint_count(); }

double PhysicsWorld::max_penetration_m() const { return impl_->step.results().max_penetration_m; }

std::uint64_t PhysicsWorld::penetration_faults() const {
  return impl_->step.results().penetration_faults;
}

const api::SolverFailures& PhysicsWorld::solver_failures() const {
  return impl_->step.solver().failures();
}

const api::SolverStep& PhysicsWorld::solver_step() const { return impl_->step.solver().latest(); }

const api::SolverWork& PhysicsWorld::solver_work() const { return impl_->step.solver().work(); }

void PhysicsWorld::observe_solver(SolverObserver observer) {
  impl_->step.set_observer(std::move(observer));
}

std::uint64_t PhysicsWorld::state_hash() const { return physics::state_hash(impl_->model); }

}  // namespace aprsim::physics
