#pragma once

#include <span>
#include <vector>

#include "world/api/snapshot.hpp"
#include "world/physics/fixed_shapes.hpp"
#include "world/physics/free_bodies.hpp"
#include "world/physics/touch.hpp"
#include "world/scene/scene.hpp"

namespace aprsim::physics {

/// Contact simplification (IMECE2019-11345) in two tiers.
///
/// Virtual joints (Algorithms 1-2): a gear at rest relative to its tray gets one fixed joint to it
/// and their contacts are switched off; the joint goes when the force it transmits departs from
/// the contact force it replaced, or when a robot touches the gear or its tray.
///
/// Parking: an island of bodies that all rest relative to one carrier (fixed things, or the belt
/// at constant speed) leaves the solver altogether, moving exactly with its carrier; a new contact
/// from outside, a change of the belt's speed or the belt's end wakes all of it.
///
/// Both need only joint forces and a per-pair collision switch of the engine.
class Simplification {
 public:
  Simplification(const scene::Physics& physics, std::span<FreeBody> bodies,
                 const FixedShapes& fixed, dWorldID world);

  [[nodiscard]] bool parked(int body) const { return at(body).group >= 0; }
  [[nodiscard]] bool same_group(int a, int b) const {
    return parked(a) && at(a).group == at(b).group;
  }
  /// Parked on the moving belt.
  [[nodiscard]] bool riding(int body) const;
  /// The tray that a gear is joined to, -1 = none.
  [[nodiscard]] int joined_to(int gear) const { return at(gear).tray; }
  [[nodiscard]] dJointID joint(int gear) const { return at(gear).joint.get(); }
  [[nodiscard]] api::GroupKind group_kind(int body) const;
  /// Number of the body's group: the lowest body in it, -1 = on its own.
  [[nodiscard]] int group(int body) const;
  /// At rest relative to what carries it.
  [[nodiscard]] bool resting(int body) const;
  [[nodiscard]] int joint_count() const;

  /// Wakes the whole group of `body`; woken bodies are appended to `woken`.
  void wake(int body, std::vector<int>& woken);
  /// A robot touches this body in this step: gives free what must not be held by a joint.
  void touched_by_robot(int body);

  /// Start of a step: the belt's speed; wakes what a change or the belt's end disturbs.
  void begin_step(double belt_speed_m_s, std::vector<int>& woken);
  /// End of a step: moves what rides the belt and judges, with the solved forces in `touches` and
  /// each free body's island in `island_of` (by body index, -1 = not solved on its own or with a
  /// gripper).
  void observe(std::span<const Touch> touches, std::span<const int> island_of, double step_s);

 private:
  struct Record {
    int tray = -1;         // joined to
    int group = -1;        // parked with
    int pair_tray = -1;    // tray it touches, candidate for a joint
    int pair_steps = 0;    // for how long at rest relative to it
    int quiet_steps = 0;   // for how long at rest relative to the carrier
    bool touched = false;  // by a robot, in this step
    bool other_contact = false;
    Eigen::Vector3d contact_force = Eigen::Vector3d::Zero();  // Fc, on the gear
    Eigen::Vector3d pair_force = Eigen::Vector3d::Zero();
    Eigen::Vector3d v_before = Eigen::Vector3d::Zero(), omega_before = Eigen::Vector3d::Zero();
    ode::Joint joint;
    dJointFeedback feedback = {};
  };
  struct Island {
    bool all_quiet = true, on_belt = false, on_fixed = false;
    double belt_min = 1e9, belt_max = -1e9;  // along the belt, of the supporting points
  };
  struct Group {
    bool used = false, on_belt = false;
    double belt_min = 0, belt_max = 0;
  };

  [[nodiscard]] const Record& at(int body) const {
    return records_[static_cast<std::size_t>(body)];
  }
  [[nodiscard]] Record& at(int body) { return records_[static_cast<std::size_t>(body)]; }
  [[nodiscard]] Eigen::Vector3d carrier_velocity(bool on_belt) const;
  [[nodiscard]] bool leaves_belt(double belt_min, double belt_max) const;
  void release(int gear);
  void join(int gear, int tray);
  void note_pairs(std::span<const Touch> touches);
  void judge_pairs(double step_s);
  void judge_joints();
  void judge_islands(std::span<const Touch> touches, std::span<const int> island_of, double step_s);
  void park(int island, std::span<const int> island_of);
  void ride(double step_s);

  bool active_, parks_;
  double speed_, accel_, force_;
  std::span<FreeBody> bodies_;
  const FixedShapes* fixed_;
  double belt_speed_ = 0;
  std::vector<Record> records_;
  std::vector<Island> islands_;  // by island number
  std::vector<Group> groups_;
};

}  // namespace aprsim::physics
