#pragma once

#include <span>
#include <vector>

#include "world/physics/bodies/static_shapes.hpp"
#include "world/physics/simplification/composites.hpp"

namespace aprsim::physics {

/// Carrier of a group that falls asleep.
struct Carrier {
  bool belt = false;
  double belt_min = 0, belt_max = 0;  ///< of the points on the belt, along it
  /// When the group is one composite on the belt alone: of its root's contact with the belt. A
  /// group without it wakes at any change of the belt's speed.
  const ContactWrenchCone* cone = nullptr;
};

/// Groups of bodies at rest on one carrier, fixed things or the belt. They are neither solved nor
/// searched for contacts, and move exactly with their carrier. On the belt they stay asleep while
/// its speed changes, as long as the required wrenches are within the contacts' cones. Poses are
/// computed on demand, and a step costs nothing per group. A group wakes if its box, swept along
/// the belt, would touch something fixed or at rest, if the belt accelerates more than its contacts
/// can bear, or if contact search finds a body at it.
class SleepingGroups {
 public:
  SleepingGroups(std::span<FreeBody> bodies, const StaticShapes& fixed,
                 const Composites& composites);

  [[nodiscard]] int group(int body) const { return group_[static_cast<std::size_t>(body)]; }
  [[nodiscard]] bool dormant(int body) const { return group(body) >= 0; }
  /// Lowest body of the group that `body` is in.
  [[nodiscard]] int lowest(int body) const { return sleeping_pose(body).lowest; }
  [[nodiscard]] std::span<const int> groups() const { return active_; }
  [[nodiscard]] int first(int group) const { return at(group).lowest; }
  /// The next body of the same group in ascending order, -1 = no more.
  [[nodiscard]] int next(int body) const { return next_[static_cast<std::size_t>(body)]; }
  /// Present box about a group.
  [[nodiscard]] Aabb box(int group) const;
  /// Pose and velocity of the centre of mass now.
  [[nodiscard]] Eigen::Isometry3d X_WB(int body) const;
  /// Readings of every body after every step; they use the compact SleepingPose only.
  [[nodiscard]] Eigen::Vector3d p_WB(int body) const {
    const SleepingPose& it = sleeping_pose(body);
    return it.belt ? it.p_W + (travel_ - it.travel) * belt_axis_W_ : it.p_W;
  }
  [[nodiscard]] const Eigen::Quaterniond& q_WB(int body) const { return sleeping_pose(body).q_WB; }
  [[nodiscard]] Eigen::Vector3d velocity(int body) const {
    if (!sleeping_pose(body).belt) return Eigen::Vector3d::Zero();
    return speed_ * belt_axis_W_;
  }
  [[nodiscard]] int root_count() const { return roots_; }
  [[nodiscard]] double belt_travel_m() const { return travel_; }
  [[nodiscard]] double belt_speed_m_s() const { return speed_; }

  /// Appends the groups that must not sleep through a step with this speed of the belt.
  void groups_to_wake(double belt_speed_m_s, double step_s, std::vector<int>& to_wake);
  /// Sets the belt's speed, after groups_to_wake() have been woken.
  void begin_step(double belt_speed_m_s) { speed_ = belt_speed_m_s; }
  /// Advances the belt's travel.
  void end_step(double step_s) { travel_ += speed_ * step_s; }

  /// `members` ascending. Gives them exactly the carrier's velocity. Returns the group.
  int sleep(std::span<const int> members, const Carrier& carrier);
  /// Brings the records of a group's bodies up to date (they stay asleep).
  void sync_poses(int group);
  /// Ends a group; its bodies move as their carrier did in the last step.
  void wake(int group);

  /// Copies the state of the same bodies' groups. The caller restores the poses and then calls
  /// record_poses().
  void restore(const SleepingGroups& from);
  void record_poses();

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [bodies, fixed, composites, belt_axis_W, group, next, lying, groups, active, spare,
           travel, speed, roots, travel_low, travel_high, accel_low, accel_high] = self;
    io(group, next, groups, active, spare, travel, speed, roots, travel_low, travel_high, accel_low,
       accel_high);
  }
  template <typename In>
  void require_valid(In& in) const {
    for (const std::size_t size : {group_.size(), next_.size(), groups_.size()}) {
      in.one_for_each(In::kFreeBody, size);
    }
    in.require(is_consistent(), "sleeping groups that do not fit together");
  }

 private:
  struct Group {
    int lowest = -1;
    bool belt = false;
    double travel = 0;                              // of the belt, at which the records' poses hold
    double travel_low = -1e30, travel_high = 1e30;  // of the belt, beyond which it meets something
    double accel_low = 0, accel_high = 0;           // of the belt, known to be bearable
    bool has_cone = false;
    ContactWrenchCone cone;
    Aabb box;  // at `travel`
    int roots = 0;

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [lowest, belt, travel, travel_low, travel_high, accel_low, accel_high, has_cone, cone,
             box, roots] = self;
      io(lowest, belt, travel, travel_low, travel_high, accel_low, accel_high, has_cone, cone, box,
         roots);
    }
  };
  /// Pose of a sleeping body, contiguous in memory with the others.
  struct SleepingPose {
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  // when the belt had moved by `travel`
    Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
    double travel = 0;
    int lowest = -1;  // of its group
    bool belt = false;
  };
  [[nodiscard]] const SleepingPose& sleeping_pose(int body) const {
    return poses_[static_cast<std::size_t>(body)];
  }
  [[nodiscard]] const Group& at(int group) const {
    return groups_[static_cast<std::size_t>(group)];
  }
  [[nodiscard]] Group& at(int group) { return groups_[static_cast<std::size_t>(group)]; }
  [[nodiscard]] FreeBody& body(int i) const { return bodies_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] Eigen::Vector3d shift(const Group& group) const;
  void record_poses(int group);
  [[nodiscard]] bool contains(const Group& group, double belt_accel) const;
  void limit_travel(Group& group, const Carrier& carrier);
  static void limit_travel_by(Group& group, const Aabb& obstacle, const Eigen::Vector3d& axis,
                              double travel);
  void update_limits();
  /// Whether every group is either active, with a valid list of its bodies, or spare.
  [[nodiscard]] bool is_consistent() const;
  [[nodiscard]] bool has_valid_list(int group, std::vector<char>& listed) const;

  std::span<FreeBody> bodies_;
  const StaticShapes* fixed_;
  const Composites* composites_;
  Eigen::Vector3d belt_axis_W_;
  std::vector<int> group_, next_;    // by body
  std::vector<SleepingPose> poses_;  // by body; of those in groups
  std::vector<Group> groups_;
  std::vector<int> active_, spare_;  // groups that sleep; records without a group
  double travel_ = 0, speed_ = 0;
  int roots_ = 0;
  // over all groups on the belt
  double travel_low_ = -1e30, travel_high_ = 1e30, accel_low_ = -1e30, accel_high_ = 1e30;
};

}  // namespace aprsim::physics
