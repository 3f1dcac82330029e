#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "world/physics/bodies/contact_constraint.hpp"
#include "world/physics/bodies/free_body.hpp"
#include "world/scene/scene.hpp"

namespace aprsim::physics {

class ConstraintSystem;

/// Contact simplification as in IMECE2019-11345, with its criteria and nothing else, so that it can
/// be compared: a touching pair of free bodies with |v1 - v2| < e1 and |a1 - a2| < e2 gets one
/// fixed joint and its contacts are switched off (Algorithm 1); the joint goes when the force that
/// it transmits departs by more than e from the contact force that it replaced (Algorithm 2). It
/// needs only joint forces and a per-pair collision switch of the engine.
class VirtualJoints {
 public:
  struct Pair {
    int a = -1, b = -1;                                       ///< a < b
    std::uint64_t serial = 0;                                 ///< in order of joining
    std::size_t joint = 0;                                    // index of its joint
    Eigen::Vector3d contact_force = Eigen::Vector3d::Zero();  // Fc, on b
    ode::SavedState at_a, at_b;                               // poses when joined
  };

  VirtualJoints(const scene::Physics& physics, std::span<FreeBody> bodies, dWorldID world);

  /// The joined pairs in ascending order.
  [[nodiscard]] std::span<const Pair> pairs() const { return pairs_; }
  [[nodiscard]] bool joined(int a, int b) const;
  [[nodiscard]] dJointID joint(const Pair& pair) const { return joints_[pair.joint].get(); }
  /// Lowest body of those that a body is joined to, directly or not; -1 = to none.
  [[nodiscard]] int group(int body) const { return group_[static_cast<std::size_t>(body)]; }

  /// Adds a pair's joint to a system that is to be solved; returns its first row, three for the
  /// force on a, then three for the torque.
  int add_to(ConstraintSystem& system, const Pair& pair) const;
  /// Notes what the joint transmitted when ODE has not solved it.
  void note_force(const Pair& pair, const Eigen::Vector3d& force_on_b);

  struct State {
    std::vector<Pair> pairs;
    std::vector<Eigen::Vector3d> forces;  ///< that the joints transmitted last, on b
    std::vector<Eigen::Vector3d> v_before;
    std::vector<int> group;
    std::uint64_t next_serial = 0;
  };
  [[nodiscard]] State save() const;
  /// Makes the same joints in the same order; leaves the bodies where they were when joined.
  void restore(const State& state);

  /// Removes the joints of a body.
  void forget(int body);

  /// After a step: both algorithms, with the solved forces in `constraints`.
  void observe(std::span<const ContactConstraint> constraints, double step_s);

 private:
  void release_changed();
  void join_resting(std::span<const ContactConstraint> constraints, double step_s);
  void join(int a, int b, const Eigen::Vector3d& force_on_b);
  [[nodiscard]] std::size_t acquire_joint();
  void attach(const Pair& pair, const Eigen::Vector3d& force_on_b);
  void detach(const Pair& pair);
  [[nodiscard]] dBodyID ode_body(int i) const {
    return bodies_[static_cast<std::size_t>(i)].body.get();
  }
  void find_groups();

  double step_s_, speed_, accel_, force_;
  std::span<FreeBody> bodies_;
  dWorldID world_;
  std::vector<Pair> pairs_;
  std::vector<ode::Joint> joints_;
  std::vector<std::unique_ptr<dJointFeedback>> feedback_;
  std::vector<std::size_t> spare_;  // joints not in use
  std::vector<Eigen::Vector3d> v_before_;
  std::vector<int> group_;
  std::uint64_t next_serial_ = 0;
};

}  // namespace aprsim::physics
