#pragma once

#include <array>
#include <span>

#include <Eigen/Geometry>

#include "world/physics/bodies/free_body.hpp"
#include "world/physics/bodies/ode_handles.hpp"
#include "world/physics/collision/narrow_phase.hpp"
#include "world/physics/gripper/finger_drive.hpp"
#include "world/physics/gripper/grasp_monitor.hpp"
#include "world/physics/gripper/gripper_constraints.hpp"
#include "world/physics/gripper/gripper_state.hpp"
#include "world/physics/gripper/gripper_wear.hpp"

namespace aprsim::physics {

/// A palm or finger as a box; `X_WS` is its centre.
struct GripperPart {
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  Eigen::Isometry3d X_TS = Eigen::Isometry3d::Identity();  ///< in the tool frame, open, unloaded
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();
  Aabb bounds;
  // velocity of the carriage's rigid motion at this part, last step
  Eigen::Vector3d carried_v = Eigen::Vector3d::Zero();
};

/// A parallel gripper on the flange, pads as high as the fingers, the palm's box on top of them: a
/// kinematic carriage, the palm on a compliant mount (a fixed joint as spring and damper: without
/// it every mis-grasp would be an infinite force), two fingers on sliders with end stops, a
/// velocity-limited piston each, and for the linkage law a lever with two rods that holds both
/// travels equal. Its weight and inertia are the arm's business: the parts move with the carriage
/// and deflect only under contact forces. Nothing ever ties a gear to it.
class GripperMechanism {
 public:
  GripperMechanism(const scene::Robot& robot, dWorldID world, const Eigen::Isometry3d& X_WF,
                   double step_s);

  /// Everything that changes from step to step, as values: what save() gives and restore() takes,
  /// between steps, of this gripper or of one built alike.
  struct State {
    std::array<GripperPart, 4> parts;  ///< palm, two fingers, lever (linkage only)
    std::array<ode::SavedState, 4> bodies;
    Eigen::Isometry3d X_WT, X_WT_next;
    Eigen::Isometry3d delta = Eigen::Isometry3d::Identity();  ///< X_WT_next X_WT^-1
    Eigen::Vector3d omega = Eigen::Vector3d::Zero();
    std::array<FingerMotion, 2> motion{};
    std::array<FingerDrive, 2> drives{};
    LawState law;
    double setting = 1;  ///< 0 closed .. 1 open, one of the two for pistons
    double force_n = 0;  ///< of each finger
    bool idle = true;
    GraspMonitor grasp;
    GripperWear wear;
    GripperState report;
  };
  [[nodiscard]] State save() const;
  void restore(const State& state);

  void command(double setting);
  /// Of each finger, from now on.
  void set_force(double force_n);
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

  static constexpr int kParts = 3;  ///< palm and two fingers
  [[nodiscard]] const GripperPart& part(int i) const {
    return now_.parts[static_cast<std::size_t>(i)];
  }
  /// Of all parts.
  [[nodiscard]] Aabb bounds() const {
    return part(0).bounds.joined(part(1).bounds).joined(part(2).bounds);
  }
  [[nodiscard]] const Pad& pad() const { return pad_; }
  [[nodiscard]] Eigen::Isometry3d X_WD(int finger) const;  ///< see Pad
  /// Direction in which a finger closes, in world.
  [[nodiscard]] Eigen::Vector3d closing_W(int finger) const;
  [[nodiscard]] const GripperState& state() const { return now_.report; }
  [[nodiscard]] double pad_friction() const {
    return now_.wear.pad_friction * settings_.pad_friction;
  }
  /// Bodies that are solved together, without the carriage.
  [[nodiscard]] std::span<const dBodyID> bodies() const { return joints_.moved(); }
  [[nodiscard]] dBodyID carriage() const { return carriage_.get(); }
  /// Puts the carriage body at the start of the step (solvers move it along).
  void place_carriage();
  /// How many rows it adds to a system at most.
  [[nodiscard]] int rows() const { return GripperConstraints(joints_, step_s_).rows(); }

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
  void read_back();
  [[nodiscard]] Eigen::Vector3d carried_velocity(const Eigen::Vector3d& p_W) const;
  [[nodiscard]] Eigen::Isometry3d resting_X_TS(std::size_t part) const;

  scene::Gripper settings_;
  double step_s_;
  Eigen::Isometry3d X_FT_;
  Pad pad_;
  GripperJoints joints_;
  std::array<ode::Body, 4> bodies_;  // of the parts
  ode::Body carriage_;
  ode::Joint mount_, hinge_;
  std::array<ode::Joint, 2> sliders_, rods_;
  State now_;
};

}  // namespace aprsim::physics
