#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "world/api/snapshot/snapshot.hpp"
#include "world/api/snapshot/solver_work.hpp"
#include "world/physics/bodies/body_grouping.hpp"
#include "world/physics/bodies/physics_failure.hpp"
#include "world/physics/constraint/contact_solver_statistics.hpp"
#include "world/physics/contacts/arm_force.hpp"
#include "world/physics/contacts/contact_pair.hpp"
#include "world/physics/gripper/gripper_state.hpp"
#include "world/physics/gripper/gripper_wear.hpp"
#include "world/physics/model/body_pose.hpp"
#include "world/physics/model/body_state.hpp"
#include "world/physics/state/physics_state.hpp"
#include "world/robot/model/arm_model.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::physics {

/// Physics of gears, trays, belt, tables, grippers and arm links. Owns a PhysicsModel with its
/// PhysicsStep and BodyPlacement. Bodies are numbered as in the scene: trays first, then gears.
/// Deterministic: the same scene and calls give the same bits. Thread: sim.
class PhysicsWorld {
 public:
  /// `X_WL` per robot: link poses at the start. The scene and arm models must outlive the world.
  PhysicsWorld(const scene::Scene& scene, std::span<const robot::ArmModel> arm_models,
               std::span<const std::vector<Eigen::Isometry3d>> X_WL);
  ~PhysicsWorld();
  PhysicsWorld(PhysicsWorld&&) noexcept;
  PhysicsWorld& operator=(PhysicsWorld&&) noexcept;

  // ---- inputs of the coming step
  /// Link poses at the end of the coming step (dof + 1); they start where the last call left them.
  void set_arm(int robot, std::span<const Eigen::Isometry3d> X_WL_next);
  void set_gripper(int robot, double setting);  ///< 0 closed .. 1 open
  /// Pose of the gripper's mount at the end of the coming step, to be called after set_arm(), which
  /// sets the flange's pose: a tool changer may hold the tool elsewhere.
  void set_gripper_mount(int robot, const Eigen::Isometry3d& X_WF_next);
  /// Force of each piston [N]; the scene's at the start.
  void set_gripper_force(int robot, double force_n);
  /// Wear of a gripper, from now on.
  void set_gripper_wear(int robot, const GripperWear& wear);
  void set_belt_speed(double speed_m_s);  ///< signed, along the belt's +x

  /// Between two steps: attaches a free tool to a robot without one, with its mount at `X_WF`, or
  /// detaches the robot's tool.
  void attach_tool(int robot, int tool, const Eigen::Isometry3d& X_WF);
  void detach_tool(int robot);

  // ---- between two steps: see BodyPlacement
  using Placement = BodyPose;
  void set_velocity(int body, const Eigen::Vector3d& v_com_W, const Eigen::Vector3d& omega_W);
  void add_impulse(int body, const Eigen::Vector3d& impulse_W, const Eigen::Vector3d& angular_W);
  void set_decoupled_from_belt(int body, bool decoupled_from_belt);
  void place(std::span<const Placement> placements);
  void remove(int body);

  /// Throws PhysicsFailure.
  void step();
  /// Counts steps that are not taken, of a cell that is at rest.
  void advance_clock(std::uint64_t steps);

  // ---- keeping a state, between two steps
  using State = PhysicsState;
  [[nodiscard]] State save() const;
  /// See PhysicsState::restore().
  void restore(const State& state);
  /// See adopt() of world/physics/state/adoption.hpp.
  void adopt(const PhysicsWorld& old, std::span<const int> old_of);

  // ---- results of the last step
  [[nodiscard]] int body_count() const;  ///< trays and gears
  [[nodiscard]] BodyState body(int index) const;
  [[nodiscard]] int tool_count() const;  ///< in the order of scene::tools_of()
  /// State of a tool in its tool frame, on a flange or not.
  [[nodiscard]] BodyState tool(int index) const;
  [[nodiscard]] int tool_of(int robot) const;    ///< -1 = none
  [[nodiscard]] double opening(int tool) const;  ///< of its fingers, pad to pad
  [[nodiscard]] GripperState gripper(int robot) const;
  /// Contact forces on links, palm and fingers; a held body loads them through the pads.
  [[nodiscard]] std::span<const ArmForce> arm_forces(int robot) const;
  [[nodiscard]] int contact_count() const;
  /// Replaces `out` by the contacts, at most api::kMaxContacts; see api::Snapshot::contacts.
  void write_contacts(std::vector<api::ContactSnapshot>& out) const;
  /// All pairs that touch, also those beyond api::kMaxContacts; until the next step.
  [[nodiscard]] const ContactPairs& contact_pairs() const;
  /// Changes whenever grouping() of some body may differ, or a body has been lost.
  [[nodiscard]] std::uint64_t grouping_version() const;
  /// Grouping of a body or, from body_count() on, of a tool.
  [[nodiscard]] BodyGrouping grouping(int id) const;
  [[nodiscard]] bool lost(int id) const;
  /// Names of what never moves; ContactSide::index counts them.
  [[nodiscard]] std::vector<std::string> fixed_names() const;
  [[nodiscard]] int virtual_joint_count() const;
  [[nodiscard]] double max_penetration_m() const;
  [[nodiscard]] std::uint64_t penetration_faults() const;
  [[nodiscard]] const api::SolverFailures& solver_failures() const;
  [[nodiscard]] const api::SolverStep& solver_step() const;
  /// Since it was built; what was restored is not taken back.
  [[nodiscard]] const api::SolverWork& solver_work() const;
  /// From here on the observer reads the course of each solve, within step(); empty = none.
  void observe_solver(SolverObserver observer);
  /// FNV-1a over the bits of every body's state.
  [[nodiscard]] std::uint64_t state_hash() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aprsim::physics
