#pragma once

#include <span>
#include <vector>

#include "world/physics/bodies/free_body.hpp"
#include "world/physics/simplification/contact_wrench_cone.hpp"

namespace aprsim::physics {

/// How a composite's motion changes in a step: its rigid body's acceleration over the step.
struct RigidMotion {
  Eigen::Vector3d origin_W = Eigen::Vector3d::Zero();  ///< of the rigid body
  Eigen::Vector3d accel_W = Eigen::Vector3d::Zero();   ///< there [m/s2]
  Eigen::Vector3d alpha_W = Eigen::Vector3d::Zero();   ///< [rad/s2]
  Eigen::Vector3d omega_W = Eigen::Vector3d::Zero();   ///< [rad/s]
};

/// Which free bodies are merged into composite rigid bodies, as trees: every member but the root
/// rests on one other member, its parent, and touches nothing else but what rests on it. The root's
/// rigid body moves all; the others' are idle. A body on its own is its own root.
class Composites {
 public:
  Composites(std::span<FreeBody> bodies, const Eigen::Vector3d& gravity_W);

  [[nodiscard]] int root(int body) const { return at(body).root; }
  [[nodiscard]] int parent(int body) const { return at(body).parent; }  ///< -1: a root
  /// The next member: a root's list runs from the root through its members in ascending order.
  [[nodiscard]] int next(int body) const { return at(body).next; }  ///< -1 = no more
  [[nodiscard]] bool is_merged(int body) const { return parent(body) >= 0 || next(body) >= 0; }
  /// The wrench cone of its contact with its parent.
  [[nodiscard]] const ContactWrenchCone& cone(int child) const { return at(child).cone; }
  [[nodiscard]] int child_count() const { return children_; }

  /// Merges the composite of `child`, a root, onto `parent`.
  void attach(int child, int parent, const ContactWrenchCone& cone);
  /// Detaches a child, with all that rests on it, from its parent.
  void detach(int child);
  /// Gives the members the pose and velocity of their root.
  void move_members(int root);

  /// The wrench that the parent must exert on `child`, in the child's frame, for it and all that
  /// rests on it to move so: Newton and Euler for its composite rigid body (Featherstone 2008,
  /// ch. 5.3 and 6.2).
  [[nodiscard]] Wrench required_wrench(int child, const RigidMotion& motion) const;
  [[nodiscard]] bool contains(int child, const RigidMotion& motion) const {
    return at(child).cone.contains(required_wrench(child, motion));
  }

  /// Copies the state of the same bodies' composites and sets the masses of rigid bodies. The
  /// caller restores the poses.
  void restore(const Composites& from);

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [bodies, gravity_W, members, moved, children] = self;
    io(members, children);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.one_for_each(In::kFreeBody, members_.size());
    in.require(is_consistent(), "merged bodies that are no trees");
  }

 private:
  struct Member {
    int root = -1, parent = -1, next = -1;
    Eigen::Isometry3d X_RB = Eigen::Isometry3d::Identity();  // in the root
    MassProperties carried;  // the body and all that rests on it, in its frame
    ContactWrenchCone cone;

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [root, parent, next, X_RB, carried, cone] = self;
      io(root, parent, next, X_RB, carried, cone);
    }
  };
  [[nodiscard]] const Member& at(int body) const {
    return members_[static_cast<std::size_t>(body)];
  }
  [[nodiscard]] Member& at(int body) { return members_[static_cast<std::size_t>(body)]; }
  [[nodiscard]] FreeBody& body(int i) const { return bodies_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] bool rests_on(int body, int below) const;
  /// Whether every body is in the list of its root, and its parents lead there.
  [[nodiscard]] bool is_consistent() const;
  [[nodiscard]] bool has_valid_list(int root, std::vector<char>& listed) const;
  void insert(int root, int member);
  void update_inertia(int root);

  std::span<FreeBody> bodies_;
  Eigen::Vector3d gravity_W_;
  std::vector<Member> members_;
  std::vector<int> moved_;  // scratch
  int children_ = 0;
};

}  // namespace aprsim::physics
