#pragma once

#include <optional>
#include <span>
#include <vector>

#include "world/api/snapshot/snapshot.hpp"
#include "world/physics/bodies/body_grouping.hpp"
#include "world/physics/bodies/contact_constraint.hpp"
#include "world/physics/bodies/free_body.hpp"
#include "world/physics/bodies/static_shapes.hpp"
#include "world/physics/simplification/composites.hpp"
#include "world/physics/simplification/frozen_contacts.hpp"
#include "world/physics/simplification/rest_detector.hpp"
#include "world/physics/simplification/sleeping_groups.hpp"
#include "world/physics/simplification/virtual_joints.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::physics {

/// Contact simplification: takes contacts of bodies at rest out of the solver. The modes:
///
/// off: none. virtual_joints: see VirtualJoints. merge: a body at rest relative to the only body
/// that it touches becomes one rigid body with it (Composites). It is unmerged if the wrench that
/// the step requires leaves the cone of their contact, if another body touches it, or if a gripper
/// or a faulty contact is near. dormant: merge, and groups at rest on fixed things or on the belt
/// sleep (SleepingGroups). Rest is detected in the same way in all modes (RestDetector).
class Simplification {
 public:
  Simplification(const scene::Physics& physics, std::span<FreeBody> bodies,
                 const StaticShapes& fixed);

  // ---- state
  [[nodiscard]] bool dormant(int body) const { return sleeping_.dormant(body); }
  /// The body whose rigid body moves this one: itself unless merged.
  [[nodiscard]] int root(int body) const { return composites_.root(body); }
  /// Bodies that are not dormant, ascending.
  [[nodiscard]] std::span<const int> awake() const { return awake_; }
  /// The roots among them.
  [[nodiscard]] std::span<const int> awake_roots() const { return awake_roots_; }
  [[nodiscard]] const Composites& composites() const { return composites_; }
  [[nodiscard]] SleepingGroups& sleeping() { return sleeping_; }
  [[nodiscard]] const SleepingGroups& sleeping() const { return sleeping_; }
  /// Pairs with virtual joints; none in other modes.
  [[nodiscard]] std::span<const VirtualJoints::Pair> joined_pairs() const;
  /// Null unless the mode is theirs.
  [[nodiscard]] VirtualJoints* virtual_joints() {
    return virtual_joints_ ? &*virtual_joints_ : nullptr;
  }
  /// Whether contacts between two bodies are switched off by a joint.
  [[nodiscard]] bool joined(int a, int b) const {
    return virtual_joints_ && virtual_joints_->joined(a, b);
  }
  [[nodiscard]] api::GroupKind group_kind(int body) const;
  /// Number of the body's group: one of its members, -1 = on its own.
  [[nodiscard]] int group(int body) const;
  /// At rest relative to what carries it.
  [[nodiscard]] bool resting(int body) const;
  [[nodiscard]] BodyGrouping grouping(int body) const;
  /// Increases with every change of grouping(), and with every lost body.
  [[nodiscard]] std::uint64_t changes() const;
  /// Number of bodies that are attached to another one, as by a joint.
  [[nodiscard]] int joint_count() const;
  /// Number of contact points that are frozen instead of solved.
  [[nodiscard]] int frozen_count() const { return merged_.count() + asleep_.count(); }
  /// Frozen contacts of merged bodies with their supports, and of sleeping groups.
  [[nodiscard]] const FrozenContacts& merged_contacts() const { return merged_; }
  [[nodiscard]] const FrozenContacts& sleeping_contacts() const { return asleep_; }
  [[nodiscard]] Eigen::Isometry3d X_WB(int body) const;
  /// Velocity of the centre of mass.
  [[nodiscard]] Eigen::Vector3d velocity(int body) const;

  struct State;
  [[nodiscard]] State save() const;
  /// The caller restores the poses afterwards.
  void restore(const State& state);

  /// Length of the coming steps.
  void set_step_s(double step_s);

  // ---- a step, in this order
  /// The belt's speed in the coming step; wakes what it disturbs.
  void begin_step(double belt_speed_m_s);
  /// While contacts are searched.
  void wake(int group);
  void touched_by_robot(int body);
  /// A gripper or a faulty contact is near this body: it must neither sleep nor be merged.
  void disturb(int body);
  /// Gives the members of a root's composite the motion of the root.
  void move_members(int root) { composites_.move_members(root); }
  /// Unmerges a body from its parent, if it has one.
  void unmerge(int body);
  /// Between two steps: removes an awake body that is lost (FreeBody::lost_step).
  void remove_lost(int body);
  /// Between two steps: removes a body that is mounted on a robot's flange (FreeBody::mounted).
  void remove_mounted(int body);
  /// Between two steps: adds an awake body that has been placed in the cell again.
  void add(int body);
  /// After the solve: appends the merged bodies whose required wrench is outside the cone of their
  /// contact. They must be unmerged and the step solved again.
  void find_overstressed(std::vector<int>& overstressed);
  /// At the end of a step: detects rest, merges bodies and lets groups fall asleep. `constraints`
  /// have the solved forces; `island_of` is each root's island (by body, -1 = with a gripper).
  void observe(std::span<const ContactConstraint> constraints, std::span<const int> island_of);

 private:
  /// Contacts and neighbours of a body.
  struct Neighbours {
    int support = -1;            // the only body that its composite touches
    bool many_supports = false;  // its composite touches more than one
    bool touched = false;        // by a robot, in this step
    bool near = false;           // a gripper or a fault, in this step

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [support, many_supports, touched, near] = self;
      io(support, many_supports, touched, near);
    }
    template <typename In>
    void require_valid(In& in) const {
      in.index_or_none(In::kFreeBody, support);
    }
  };
  struct Island {
    bool quiet = true, on_belt = false, on_fixed = false;
    int roots = 0;
    double belt_min = 1e30, belt_max = -1e30;  // along the belt, of the supporting points
  };

  [[nodiscard]] const Neighbours& at(int body) const {
    return neighbours_[static_cast<std::size_t>(body)];
  }
  [[nodiscard]] Neighbours& at(int body) { return neighbours_[static_cast<std::size_t>(body)]; }
  [[nodiscard]] FreeBody& body(int i) const { return bodies_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] bool is_free(int id) const;
  void list_awake();
  void find_supports(std::span<const ContactConstraint> constraints);
  void add_support(int a, int b);
  void update_islands(std::span<const ContactConstraint> constraints,
                      std::span<const int> island_of);
  void count_on_carrier(int i, const Island& island);
  void update_pairs(std::span<const ContactConstraint> constraints, std::span<const int> island_of);
  void merge(int child, int support, std::span<const ContactConstraint> constraints,
             std::span<const int> island_of);
  /// Position at the end of the step of a contact point that was detected at its start.
  [[nodiscard]] Eigen::Vector3d position_at_end(const Contact& contact) const;
  [[nodiscard]] ContactWrenchCone cone_of(int child, int support,
                                          std::span<const ContactConstraint> constraints) const;
  void fall_asleep(std::span<const ContactConstraint> constraints, std::span<const int> island_of);

  bool merges_, sleeps_;
  double step_s_;
  Eigen::Vector3d gravity_W_;
  std::span<FreeBody> bodies_;
  const StaticShapes* fixed_;
  Composites composites_;
  SleepingGroups sleeping_;
  std::optional<VirtualJoints> virtual_joints_;
  RestDetector rest_;
  FrozenContacts merged_, asleep_;  // by child; by sleeping group
  std::vector<Neighbours> neighbours_;
  std::vector<Island> islands_;  // by island number
  std::vector<int> awake_, awake_roots_, scratch_;
  double belt_speed_before_ = 0;
  std::uint64_t changes_ = 0;  // without those of virtual joints
};

/// All that changes from step to step.
struct Simplification::State {
  Composites composites;
  SleepingGroups sleeping;
  std::optional<VirtualJoints::State> virtual_joints;
  RestDetector::State rest;
  FrozenContacts merged_contacts, sleeping_contacts;
  std::vector<Neighbours> neighbours;
  double belt_speed_before = 0;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [composites, sleeping, virtual_joints, rest, merged_contacts, sleeping_contacts,
           neighbours, belt_speed_before] = self;
    io(composites, sleeping, virtual_joints, rest, merged_contacts, sleeping_contacts, neighbours,
       belt_speed_before);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.one_for_each(In::kFreeBody, rest.size());
    in.one_for_each(In::kFreeBody, neighbours.size());
  }
};

}  // namespace aprsim::physics
