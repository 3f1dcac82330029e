#pragma once

#include <array>
#include <span>

#include <Eigen/Geometry>

#include "world/physics/bodies/rigid_body.hpp"
#include "world/physics/gripper/finger_drive.hpp"
#include "world/physics/gripper/finger_rail.hpp"
#include "world/physics/gripper/gripper_constraints.hpp"
#include "world/physics/gripper/gripper_parts.hpp"
#include "world/physics/gripper/mount_motion.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::physics {

/// The rigid bodies of a gripper and the joints between them, as the solver sees them: the palm on
/// a compliant mount (a fixed joint as spring and damper: without it every mis-grasp would be an
/// infinite force), two fingers on rails, and for the linkage law a lever with two rods that keeps
/// both travels equal. A kinematic carriage moves the mount. The arm bears weight and inertia: the
/// bodies move with the carriage and deflect only under contact forces. Along their rails the
/// fingers bear their own.
class GripperBodies {
 public:
  GripperBodies(const scene::Gripper& gripper, const scene::Physics& physics,
                const GripperParts& open);

  /// Length of the coming steps.
  void set_step_s(double step_s);
  [[nodiscard]] double step_s() const { return step_s_; }
  /// Travel of the closed end stop.
  [[nodiscard]] double closed_travel_m() const { return joints_.closed_travel_m; }

  /// All but the carriage.
  [[nodiscard]] std::span<const RigidBody> all() const {
    return {bodies_.data(), joints_.body_count()};
  }
  /// Body of a part: palm or cup, or a finger.
  [[nodiscard]] RigidBody& of_part(int part) { return bodies_[index(part)]; }
  [[nodiscard]] const RigidBody& of_part(int part) const { return bodies_[index(part)]; }
  /// Measured on the rails; zero without fingers.
  [[nodiscard]] std::array<FingerMotion, 2> finger_motion() const;

  /// Sets the bodies to the poses of the parts, moving with the mount.
  void follow(const GripperParts& parts, const MountMotion& mount);
  /// Turns the bodies' velocities with the mount; `omega_before_W`: its rate in the step before.
  void begin_step(const GripperParts& parts, const MountMotion& mount,
                  const Eigen::Vector3d& omega_before_W);
  /// Adds bodies, joints, pistons and end stops to an engine.
  void add_to(Engine& engine, const GripperParts& parts, const MountMotion& mount,
              const std::array<FingerMotion, 2>& motion, const std::array<FingerDrive, 2>& drives);

  /// The part of the state that changes when a step is solved.
  struct Solved {
    std::array<BodyMotion, 4> bodies;  ///< palm, two fingers, lever (linkage only)
    GripperForces forces;

    /// See world/archive/archive.hpp.
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [bodies, forces] = self;
      io(bodies, forces);
    }
  };
  void save(Solved& to) const;
  void restore(const Solved& from);

  struct State {
    Solved solved;
    std::array<Eigen::Vector3d, 4> carried_v_W;
    Eigen::Vector3d relaxed_S = Eigen::Vector3d::Zero();

    /// See world/archive/archive.hpp.
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [solved, carried_v_W, relaxed_S] = self;
      io(solved, carried_v_W, relaxed_S);
    }
  };
  [[nodiscard]] State save() const;
  void restore(const State& state);

 private:
  void make_rail(std::size_t i, const GripperParts& open);
  void make_linkage(const GripperParts& open);
  void relax(const GripperParts& parts, const MountMotion& mount);
  void place_carriage(const GripperParts& parts, const MountMotion& mount);
  [[nodiscard]] std::span<RigidBody> moved() { return {bodies_.data(), joints_.body_count()}; }
  [[nodiscard]] std::size_t index(int part) const {
    return joints_.fingers ? static_cast<std::size_t>(part) : 0;
  }

  GripperJoints joints_;
  double step_s_ = 0, palm_stiffness_n_m_, palm_damping_ns_m_;
  double relaxation_, relaxation_s_;
  // rest position of the mount's spring, in the frame of the undeflected palm
  Eigen::Vector3d relaxed_S_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d gravity_W_;
  std::array<RigidBody, 4> bodies_;
  RigidBody carriage_;
  std::array<FingerRail, 2> rails_;
  GripperForces forces_;
  // velocity of the mount's rigid motion at each body, last step
  std::array<Eigen::Vector3d, 4> carried_v_W_;
};

}  // namespace aprsim::physics
