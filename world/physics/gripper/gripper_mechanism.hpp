#pragma once

#include <array>
#include <optional>
#include <span>

#include <Eigen/Geometry>

#include "world/physics/collision/speculative/speculative_contacts.hpp"
#include "world/physics/gripper/grasp_monitor.hpp"
#include "world/physics/gripper/gripper_actuator.hpp"
#include "world/physics/gripper/gripper_bodies.hpp"
#include "world/physics/gripper/gripper_parts.hpp"
#include "world/physics/gripper/gripper_state.hpp"
#include "world/physics/gripper/mount_motion.hpp"
#include "world/physics/gripper/suction_cup.hpp"

namespace aprsim::physics {

/// A parallel gripper or a vacuum gripper, on a flange or on none. GripperActuator and SuctionCup
/// drive it, GripperParts has its geometry, GripperBodies its dynamics under contact, GraspMonitor
/// detects grasps. With a cup there are no fingers: the cup is part of the palm, and a part is held
/// against its lip by contact. An untouched gripper at an end stop is idle: it follows the flange
/// without being solved. A grasp is contact and friction, never an attachment.
class GripperMechanism {
 public:
  /// A gripper that is on no flange; `X_WF` is any pose.
  GripperMechanism(const scene::Gripper& gripper, const scene::Physics& physics,
                   const Eigen::Isometry3d& X_WF);

  // ---- between two steps
  /// Attaches it to a mount at `X_WF`, with the tool frame at `X_FT`. The fingers keep their
  /// travels; their chambers fill again.
  void attach(const Eigen::Isometry3d& X_WF, const Eigen::Isometry3d& X_FT);
  /// Detaches it from its mount. Without air the fingers keep their travels.
  void detach();
  void command(double setting);  ///< see GripperActuator, as the next two
  void set_force(double force_n);
  void set_wear(const GripperWear& wear);
  /// Length of the coming steps.
  void set_step_s(double step_s) { bodies_.set_step_s(step_s); }

  /// Everything that changes from step to step, as values. restore() accepts the state of any
  /// gripper with the same settings.
  struct State {
    GripperParts::State parts;
    GripperBodies::State bodies;
    GripperActuator::State actuator;
    SuctionCup::State cup;
    bool mounted = false;
    Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();
    MountMotion mount;
    std::array<FingerMotion, 2> motion{};
    std::array<FingerDrive, 2> drives{};
    bool idle = true;
    GraspMonitor grasp;
    GripperState report;

    static constexpr bool kAsMany = true;  ///< as the scene has
    /// See world/archive/archive.hpp.
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [parts, bodies, actuator, cup, mounted, X_FT, mount, motion, drives, idle, grasp,
             report] = self;
      io(parts, bodies, actuator, cup, mounted, X_FT, mount, motion, drives, idle, grasp, report);
    }
  };
  [[nodiscard]] State save() const;
  void restore(const State& state);

  // ---- a step, in this order
  /// The mount moves to `X_WF_next` in this step.
  void begin_step(const Eigen::Isometry3d& X_WF_next);
  /// A body is near: not idle for some steps.
  void wake();
  /// A cup's ejector is on, or there is vacuum left.
  [[nodiscard]] bool has_suction() const;
  /// Once a step, with a cup: see SuctionCup.
  void advance_suction(const LipSeal& seal, int body, double share);
  void vent_cup();
  /// Adds bodies, joints and drives to an engine.
  void add_to(Engine& engine);
  /// Sets the parts' poses from the mount or from the solved bodies.
  void end_step();
  /// See GraspMonitor; `touched` by anything.
  void observe(const PadForces& pads, bool touched);

  /// A step may be undone: the state that solving it changes.
  void save(GripperBodies::Solved& to) const { bodies_.save(to); }
  void restore(const GripperBodies::Solved& from) { bodies_.restore(from); }

  // ---- readings
  [[nodiscard]] bool idle() const { return idle_; }
  [[nodiscard]] const GripperState& state() const { return report_; }
  [[nodiscard]] const GripperParts& parts() const { return parts_; }
  [[nodiscard]] double pad_friction() const { return actuator_.pad_friction(); }
  /// Null for a gripper with fingers.
  [[nodiscard]] const SuctionCup* cup() const { return cup_ ? &*cup_ : nullptr; }
  /// None for a gripper with fingers.
  [[nodiscard]] Suction suction() const { return cup_ ? cup_->suction() : Suction{}; }
  /// A part's velocity in a step that has begun.
  [[nodiscard]] BodyVelocity part_velocity(int part) const;
  /// Pose of the mount between two steps.
  [[nodiscard]] Eigen::Isometry3d X_WF() const { return mount_.X_WT * X_FT_.inverse(); }
  /// Velocity in the last step of the point at `p_W` that moves with the mount.
  [[nodiscard]] Eigen::Vector3d mount_velocity(const Eigen::Vector3d& p_W) const {
    return mount_.velocity_at(p_W, bodies_.step_s());
  }
  [[nodiscard]] const Eigen::Vector3d& mount_omega() const { return mount_.omega_W; }
  [[nodiscard]] std::span<const RigidBody> bodies() const { return bodies_.all(); }
  /// The body of a part: a cup is its palm's.
  [[nodiscard]] RigidBody& body_of(int part) { return bodies_.of_part(part); }

 private:
  void become_idle();
  void follow_mount();
  void read_from_bodies();
  [[nodiscard]] double stop_travel_m() const {
    return actuator_.stop_travel_m(bodies_.closed_travel_m());
  }
  [[nodiscard]] bool observe_fingers(const PadForces& pads, bool touched);
  [[nodiscard]] bool observe_cup(bool touched);

  double gap_open_m_;
  GripperActuator actuator_;
  std::optional<SuctionCup> cup_;
  bool mounted_ = false;
  Eigen::Isometry3d X_FT_ = Eigen::Isometry3d::Identity();
  MountMotion mount_;
  GripperParts parts_;
  GripperBodies bodies_;
  std::array<FingerMotion, 2> motion_{};
  std::array<FingerDrive, 2> drives_{};
  bool idle_ = true;
  GraspMonitor grasp_;
  GripperState report_;
};

}  // namespace aprsim::physics
