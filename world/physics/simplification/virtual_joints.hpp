#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "world/physics/bodies/contact_constraint.hpp"
#include "world/physics/bodies/free_body.hpp"
#include "world/physics/engine/engine.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::physics {

/// Contact simplification as in IMECE2019-11345, with its criteria and nothing else, so that it can
/// be compared: a touching pair of free bodies with |v1 - v2| < e1 and |a1 - a2| < e2 gets one
/// fixed joint and its contacts are switched off (Algorithm 1); the joint is removed if its
/// force differs by more than e from the contact force that it replaced (Algorithm 2). It
/// needs only joint forces and a per-pair collision switch of the engine.
class VirtualJoints {
 public:
  struct Pair {
    int a = -1, b = -1;                                       ///< a < b
    std::uint64_t serial = 0;                                 ///< in order of joining
    Eigen::Vector3d contact_force = Eigen::Vector3d::Zero();  // Fc, on b
    Eigen::Isometry3d X_WA = Eigen::Isometry3d::Identity();   ///< when joined
    Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
    std::array<JointForce, 6> forces;  // on a: force and torque at b's origin, in the last step

    [[nodiscard]] Eigen::Vector3d force_on_b() const {
      return {-forces[0].last_n(), -forces[1].last_n(), -forces[2].last_n()};
    }

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [a, b, serial, contact_force, X_WA, X_WB, forces] = self;
      io(a, b, serial, contact_force, X_WA, X_WB, forces);
    }
    template <typename In>
    void require_valid(In& in) const {
      in.index(In::kFreeBody, a, b);
      in.require(a < b, "a virtual joint in the wrong order");
    }
  };

  VirtualJoints(const scene::Physics& physics, std::span<FreeBody> bodies);

  /// The joined pairs in ascending order.
  [[nodiscard]] std::span<const Pair> pairs() const { return pairs_; }
  [[nodiscard]] bool joined(int a, int b) const;
  /// Lowest body of those that a body is joined to, directly or not; -1 = to none.
  [[nodiscard]] int group(int body) const { return group_[static_cast<std::size_t>(body)]; }

  /// Increases with every pair that is joined or separated.
  [[nodiscard]] std::uint64_t changes() const { return 2 * next_serial_ - pairs_.size(); }

  /// Adds a pair's joint to an engine.
  void add_to(Engine& engine, std::size_t pair);

  struct State {
    std::vector<Pair> pairs;
    std::vector<Eigen::Vector3d> v_before;
    std::vector<int> group;
    std::uint64_t next_serial = 0;

    static constexpr bool kAsMany = true;  ///< as the scene has
    /// See world/archive/archive.hpp.
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [pairs, v_before, group, next_serial] = self;
      io(pairs, v_before, group, next_serial);
    }
    template <typename In>
    void require_valid(In& in) const {
      in.one_for_each(In::kFreeBody, v_before.size());
      in.one_for_each(In::kFreeBody, group.size());
      for (const int of_body : group) in.index_or_none(In::kFreeBody, of_body);
      const auto in_order = [](const Pair& first, const Pair& second) {
        return first.a < second.a || (first.a == second.a && first.b < second.b);
      };
      for (std::size_t i = 1; i < pairs.size(); ++i) {
        in.require(in_order(pairs[i - 1], pairs[i]), "virtual joints out of order");
      }
    }
  };
  [[nodiscard]] State save() const { return {pairs_, v_before_, group_, next_serial_}; }
  void restore(const State& state);

  /// Removes the joints of a body.
  void remove_joints_of(int body);
  /// Length of the coming steps.
  void set_step_s(double step_s) { step_s_ = step_s; }

  /// After a step: both algorithms, with the solved forces in `constraints`.
  void observe(std::span<const ContactConstraint> constraints);

 private:
  void release_changed();
  void join_resting(std::span<const ContactConstraint> constraints);
  void join(int a, int b, const Eigen::Vector3d& force_on_b);
  [[nodiscard]] RigidBody& rigid_body(int i) const {
    return bodies_[static_cast<std::size_t>(i)].body;
  }
  void find_groups();

  double step_s_, speed_, accel_, force_;
  std::span<FreeBody> bodies_;
  std::vector<Pair> pairs_;
  std::vector<Eigen::Vector3d> v_before_;
  std::vector<int> group_;
  std::uint64_t next_serial_ = 0;
};

}  // namespace aprsim::physics
