#pragma once

#include "world/physics/collision/contact.hpp"

namespace aprsim::physics {

/// A contact of the present step with what the solver needs and what it finds out. The first body
/// is always one that moves freely or a part of a gripper.
struct ContactConstraint {
  Contact contact;
  int fixed = -1;  ///< index of the fixed shape when contact.b is kGround
  double friction = 0;
  bool belt = false;
  bool cut = false;  ///< between a body solved directly and one solved after it
  Eigen::Vector3d f_W = Eigen::Vector3d::Zero();  ///< solved force on contact.a
  double normal_n = 0;                            ///< its normal part
};

inline constexpr std::size_t kTouchCapacity = 4096;  ///< places to reserve for touches

/// Links of one arm touch each other only if they are so many links apart.
inline constexpr int kSelfCollisionDistance = 3;

inline constexpr double kFaultDepth = 0.5e-3;  ///< [m] of penetration: a physics fault

/// Numbers of all bodies that can touch: free bodies as in the scene, then each robot's palm,
/// fingers and links.
class BodyIds {
 public:
  BodyIds() = default;
  BodyIds(int free_count, int robots) : free_(free_count), robots_(robots) {}

  [[nodiscard]] int free_count() const { return free_; }
  [[nodiscard]] int palm(int robot) const { return free_ + robot * kPerRobot; }
  [[nodiscard]] int finger(int robot, int i) const { return palm(robot) + 1 + i; }
  [[nodiscard]] int link(int robot, int link) const { return palm(robot) + 3 + link; }

  [[nodiscard]] bool is_free(int node) const { return node >= 0 && node < free_; }
  [[nodiscard]] bool is_robot(int node) const { return node >= free_; }
  [[nodiscard]] int robot_of(int node) const { return (node - free_) / kPerRobot; }
  [[nodiscard]] int part_of(int node) const {
    return (node - free_) % kPerRobot;
  }  ///< 0 palm, 1-2 fingers
  [[nodiscard]] bool is_gripper(int node) const { return is_robot(node) && part_of(node) < 3; }
  [[nodiscard]] bool is_finger(int node) const { return is_gripper(node) && part_of(node) > 0; }
  [[nodiscard]] bool is_link(int node) const { return is_robot(node) && part_of(node) >= 3; }
  [[nodiscard]] int link_of(int node) const { return part_of(node) - 3; }

 private:
  static constexpr int kPerRobot = 16;
  int free_ = 0, robots_ = 0;
};

/// Whether there still is a gap: a touch that the step may sync_poses about, there for the solver
/// only.
[[nodiscard]] inline bool is_gap(const ContactConstraint& touch) {
  return touch.contact.depth_m < 0;
}

/// Whether bodies are so deep in each other that the step counts as faulty. Links are soft on
/// purpose: an arm that crushes a part is the arm's fault, not the solver's.
[[nodiscard]] inline bool is_fault(const ContactConstraint& touch, const BodyIds& nodes) {
  return touch.contact.depth_m > kFaultDepth && !nodes.is_link(touch.contact.b);
}

}  // namespace aprsim::physics
