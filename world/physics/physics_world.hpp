#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "world/api/snapshot/snapshot.hpp"
#include "world/api/snapshot/solver_work.hpp"
#include "world/physics/bodies/physics_failure.hpp"
#include "world/physics/bodies/ties.hpp"
#include "world/physics/constraint/contact_solver_statistics.hpp"
#include "world/physics/contacts/arm_force.hpp"
#include "world/physics/contacts/contact_pair.hpp"
#include "world/physics/gripper/gripper_state.hpp"
#include "world/physics/gripper/gripper_wear.hpp"
#include "world/robot/model/arm_model.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::archive {
class Writer;
class Reader;
}  // namespace aprsim::archive

namespace aprsim::physics {

/// State of a free body (gear or tray) in its own frame (see api::BodyDescription).
struct BodyState {
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
  Eigen::Vector3d v_W = Eigen::Vector3d::Zero();  ///< of the frame origin
  Eigen::Vector3d omega_W = Eigen::Vector3d::Zero();
  bool resting = false;
  std::optional<std::uint64_t> lost_step;  ///< in which it fell out of the cell
  api::GroupKind group_kind = api::GroupKind::kNone;
  int group = -1;  ///< bodies of one number are simplified together, -1 = none
};

/// Gears, trays, belt, tables, grippers and arm bodies in ODE: contact generation, solver policy,
/// contact simplification, tool changers. Bodies are numbered as in the scene: trays first, then
/// gears.
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
  /// Where the links are at the end of the coming step (dof + 1 poses); they start where the last
  /// call left them.
  void set_arm(int robot, std::span<const Eigen::Isometry3d> X_WL_next);
  void set_gripper(int robot, double setting);  ///< 0 closed .. 1 open
  /// Where the gripper's mount is at the end of the coming step: at the flange, or where the tool
  /// changer has left it. Follows the flange of set_arm() unless told otherwise after it.
  void set_gripper_mount(int robot, const Eigen::Isometry3d& X_WF_next);
  /// What each piston pushes with [N]; the scene's at the start.
  void set_gripper_force(int robot, double force_n);
  /// What is wrong with a gripper, from now on.
  void set_gripper_wear(int robot, const GripperWear& wear);
  void set_belt_speed(double speed_m_s);  ///< signed, along the belt's +x

  /// Between two steps: a tool changer locks a tool that no robot has to a robot without one, its
  /// mount at `X_WF`, or lets go of what the robot has.
  void take_tool(int robot, int tool, const Eigen::Isometry3d& X_WF);
  void leave_tool(int robot);

  /// Strikes a free body: it wakes, leaves what it is merged with, and moves like this from now on;
  /// the velocity is that of its centre of mass.
  void set_velocity(int body, const Eigen::Vector3d& v_com_W, const Eigen::Vector3d& omega_W);

  /// From now on: whether the belt leaves a body behind that lies on it.
  void set_jammed(int body, bool jammed);
  /// Puts bodies down elsewhere, at rest and all as high above the poses given as the highest that
  /// needs it: clear of all other things, as far as their boxes tell. Everything wakes. Bodies that
  /// are lost stay so.
  struct Placement {
    int body = 0;
    Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  };
  void put(std::span<const Placement> placements);
  /// Takes a body out of the cell: it is lost.
  void take_away(int body);

  /// Throws PhysicsFailure before ODE would abort.
  void step();

  /// All that later steps depend on, between two steps: an immutable value, cheap to copy.
  class State {
   public:
    State() = default;  ///< of no world; restore() refuses it
    /// Of memory; approximately.
    [[nodiscard]] std::size_t bytes() const;
    /// As bytes (world/archive/archive.hpp), and back into a state of a world of the same scene,
    /// whose numbers of bodies and robots rule. Throws archive::Damaged.
    void write(archive::Writer& out) const;
    void read(archive::Reader& in);

   private:
    friend class PhysicsWorld;
    struct Data;
    std::shared_ptr<const Data> data_;
  };
  [[nodiscard]] State save() const;
  /// Goes on from there bit for bit; this world must have been built of the same scene with the
  /// same initial link poses. Throws std::invalid_argument when the numbers of bodies or robots
  /// differ.
  void restore(const State& state);

  /// Takes over a world of the same robots, tools and surroundings: `old_of` tells which of its
  /// bodies each one here is, -1 = a new one, which stays where the scene has it. All that rested
  /// wakes, and contacts are found anew: not bit for bit what would have been, but the same
  /// whenever it is done.
  void adopt(const PhysicsWorld& old, std::span<const int> old_of);

  // ---- results of the last step
  [[nodiscard]] int body_count() const;  ///< trays and gears
  [[nodiscard]] BodyState body(int index) const;
  [[nodiscard]] int tool_count() const;  ///< in the order of scene::tools_of()
  /// In its tool frame, wherever it is.
  [[nodiscard]] BodyState tool(int index) const;
  [[nodiscard]] int tool_of(int robot) const;    ///< -1 = none
  [[nodiscard]] double opening(int tool) const;  ///< of its fingers, pad to pad
  [[nodiscard]] GripperState gripper(int robot) const;
  /// Contact forces on links, palm and fingers; what is held loads them through the pads.
  [[nodiscard]] std::span<const ArmForce> arm_forces(int robot) const;
  [[nodiscard]] int contact_count() const;
  /// Replaces `out` by the contacts, at most api::kMaxContacts; see api::Snapshot::contacts.
  void write_contacts(std::vector<api::ContactSnapshot>& out) const;
  /// All pairs that touch, also those beyond api::kMaxContacts; until the next step.
  [[nodiscard]] const ContactPairs& contact_pairs() const;
  /// Another number whenever ties() of some body may differ, or a body has been lost.
  [[nodiscard]] std::uint64_t ties_version() const;
  /// Of a body or, from body_count() on, a tool.
  [[nodiscard]] Ties ties(int id) const;
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
