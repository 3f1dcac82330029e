#pragma once

#include <array>
#include <span>

#include <Eigen/Geometry>

#include "world/physics/bodies/free_body.hpp"
#include "world/physics/bodies/ode_handles.hpp"
#include "world/physics/collision/pairs/narrow_phase.hpp"
#include "world/physics/collision/speculative/look_ahead.hpp"
#include "world/physics/gripper/finger_drive.hpp"
#include "world/physics/gripper/grasp_monitor.hpp"
#include "world/physics/gripper/gripper_constraints.hpp"
#include "world/physics/gripper/gripper_state.hpp"
#include "world/physics/gripper/gripper_wear.hpp"
#include "world/physics/gripper/suction.hpp"

namespace aprsim::physics {

/// A palm or finger as a box; `X_WS` is its centre.
struct GripperPart {
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  Eigen::Isometry3d X_TS = Eigen::Isometry3d::Identity();  ///< in the tool frame, open, unloaded
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();
  Aabb bounds;
  // velocity of the carriage's rigid motion at this part, last step
  Eigen::Vector3d carried_v = Eigen::Vector3d::Zero();

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [size, X_TS, X_WS, bounds, carried_v] = self;
    io(size, X_TS, X_WS, bounds, carried_v);
  }
};

/// What a cup draws in one step.
struct Suction {
  int body = -1;            ///< that covers most of the lip, by body index; -1 = none, or fixed
  double force_n = 0;       ///< on it, against the approach; the palm bears the reaction
  bool steady = true;       ///< the vacuum has come within 1 % of what it will be
  double full_force_n = 1;  ///< at the highest vacuum, with the lip covered

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [body, force_n, steady, full_force_n] = self;
    io(body, force_n, steady, full_force_n);
  }
};

/// A parallel gripper on the flange, pads as high as the fingers, the palm's box on top of them: a
/// kinematic carriage, the palm on a compliant mount (a fixed joint as spring and damper: without
/// it every mis-grasp would be an infinite force), two fingers on sliders with end stops, a
/// velocity-limited piston each, and for the linkage law a lever with two rods that holds both
/// travels equal. With a vacuum cup there are no fingers: the cup is part of the palm, and what it
/// draws is held against its lip by contact. Its weight and inertia are the arm's business: the
/// parts move with the carriage and deflect only under contact forces; but the fingers bear their
/// own along their rails. Nothing ever ties a gear to it.
class GripperMechanism {
 public:
  /// Of a gripper that is on no flange; `X_WF` is any place.
  GripperMechanism(const scene::Gripper& gripper, dWorldID world, const Eigen::Isometry3d& X_WF,
                   double step_s);

  /// Puts it on a mount at `X_WF`, the tool frame at `X_FT`. The fingers are where they were; their
  /// chambers fill anew.
  void take(const Eigen::Isometry3d& X_WF, const Eigen::Isometry3d& X_FT);
  /// Takes it out of the cell. Without air the fingers stay where they are.
  void leave();
  [[nodiscard]] bool mounted() const { return now_.mounted; }
  /// The motion of the mount at p_W in the last step.
  [[nodiscard]] Eigen::Vector3d mount_velocity(const Eigen::Vector3d& p_W) const {
    return carried_velocity(p_W);
  }
  [[nodiscard]] const Eigen::Vector3d& mount_omega() const { return now_.omega; }

  /// Everything that changes from step to step, as values: what save() gives and restore() takes,
  /// between steps, of this gripper or of one built alike.
  struct State {
    std::array<GripperPart, 4> parts;  ///< palm, two fingers, lever (linkage only)
    std::array<ode::SavedState, 4> bodies;
    bool mounted = false;
    Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d X_WT, X_WT_next;
    Eigen::Isometry3d delta = Eigen::Isometry3d::Identity();  ///< X_WT_next X_WT^-1
    Eigen::Vector3d omega = Eigen::Vector3d::Zero();
    std::array<FingerMotion, 2> motion{};
    std::array<FingerDrive, 2> drives{};
    LawState law;
    GripperForces forces;
    double setting = 1;  ///< 0 closed .. 1 open, one of the two for pistons
    double force_n = 0;  ///< of each finger
    Suction suction;
    bool idle = true;
    GraspMonitor grasp;
    GripperWear wear;
    GripperState report;

    static constexpr bool kAsMany = true;  ///< as the scene has
    /// See world/archive/archive.hpp.
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [parts, bodies, mounted, X_FT, X_WT, X_WT_next, delta, omega, motion, drives, law,
             forces, setting, force_n, suction, idle, grasp, wear, report] = self;
      io(parts, bodies, mounted, X_FT, X_WT, X_WT_next, delta, omega, motion, drives, law, forces,
         setting, force_n, suction, idle, grasp, wear, report);
    }
  };
  [[nodiscard]] State save() const;
  void restore(const State& state);

  void command(double setting);
  /// Of each finger, from now on.
  void set_force(double force_n);
  /// Length of the coming steps.
  void set_step_s(double step_s);
  /// From now on.
  void set_wear(const GripperWear& wear);
  /// The mount goes from where it is to `X_WF_next` in this step. Moves what is carried along.
  void begin_step(const Eigen::Isometry3d& X_WF_next);
  /// Adds its bodies, joints, pistons and the forces of its law to a system that is to be solved.
  void add_to(ConstraintSystem& system);
  /// Forces of the law; once before each solve by ODE.
  void apply_forces();
  /// Puts the carriage where kinematics says, reads back the parts.
  void end_step();
  /// See GraspMonitor; `touched` by anything.
  void observe(const PadForces& pads, bool touched);

  /// At an end stop with nothing touching, the mechanism follows the flange without being solved.
  [[nodiscard]] bool idle() const { return now_.idle; }
  void wake();

  [[nodiscard]] const std::optional<scene::VacuumCup>& cup() const { return settings_.cup; }
  /// The ejector is on, or there is vacuum left.
  [[nodiscard]] bool draws() const;
  /// Once a step: how the lip lies, and on which body with which share of it (-1 = on none that
  /// moves).
  void draw(const LipSeal& seal, int body, double share);
  void draw_nothing();
  [[nodiscard]] const Suction& suction() const { return now_.suction; }
  /// The lip's centre, z along the approach, where it really is.
  [[nodiscard]] Eigen::Isometry3d X_WLip() const {
    return now_.parts[0].X_WS * now_.parts[0].X_TS.inverse();
  }
  /// Of the part with this number in BodyIds: a cup is its palm's.
  [[nodiscard]] dBodyID body_of(int part) const {
    return joints_.bodies[joints_.fingers ? static_cast<std::size_t>(part) : 0];
  }

  static constexpr int kParts = 3;  ///< palm and two fingers
  [[nodiscard]] const GripperPart& part(int i) const {
    return now_.parts[static_cast<std::size_t>(i)];
  }
  /// Of all parts.
  [[nodiscard]] Aabb bounds() const {
    return part(0).bounds.joined(part(1).bounds).joined(part(2).bounds);
  }
  [[nodiscard]] const Pad& pad() const { return pad_; }
  [[nodiscard]] const detail::GearShape& cup_solid() const { return cup_solid_; }
  [[nodiscard]] Eigen::Isometry3d X_WD(int finger) const;  ///< see Pad
  /// Of a part, in a step that has begun.
  [[nodiscard]] Moving moving(int part) const;
  /// Direction in which a finger closes, in world.
  [[nodiscard]] Eigen::Vector3d closing_W(int finger) const;
  [[nodiscard]] const GripperState& state() const { return now_.report; }
  [[nodiscard]] double pad_friction() const {
    return now_.wear.pad_friction * settings_.pad_friction;
  }
  /// Bodies that are solved together, without the carriage.
  [[nodiscard]] std::span<const dBodyID> bodies() const { return joints_.moved(); }
  [[nodiscard]] dBodyID carriage() const { return carriage_.get(); }
  /// Where the mount is between two steps.
  [[nodiscard]] Eigen::Isometry3d X_WF() const { return now_.X_WT * now_.X_FT.inverse(); }
  /// Puts the carriage body at the start of the step (solvers move it along).
  void place_carriage();
  /// What a step may change before it is undone.
  struct Solved {
    std::array<ode::SavedState, 4> bodies;
    GripperForces forces;
  };
  void save(Solved& to) const;
  void restore(const Solved& from);

 private:
  void make_parts(dWorldID world);
  void make_mount(dWorldID world);
  void make_slider(dWorldID world, int i);
  void make_linkage(dWorldID world);
  void set_drives();
  [[nodiscard]] bool closing() const { return now_.setting <= 0.5; }  ///< of pistons
  /// Travel at which the fingers stop with nothing between them.
  [[nodiscard]] double stop_travel() const { return (1 - now_.setting) * joints_.closed_travel_m; }
  void become_idle();
  void move_with_mount();
  void enable(bool on);
  void read_back();
  void place_cup();
  [[nodiscard]] bool observe_cup(bool touched);
  [[nodiscard]] Eigen::Vector3d carried_velocity(const Eigen::Vector3d& p_W) const;
  [[nodiscard]] Eigen::Isometry3d resting_X_TS(std::size_t part) const;

  scene::Gripper settings_;
  double step_s_;
  Eigen::Vector3d gravity_W_;
  Pad pad_;
  detail::GearShape cup_solid_;
  GripperJoints joints_;
  std::array<ode::Body, 4> bodies_;  // of the parts
  ode::Body carriage_;
  ode::Joint mount_, hinge_;
  std::array<ode::Joint, 2> sliders_, rods_;
  State now_;
};

}  // namespace aprsim::physics
