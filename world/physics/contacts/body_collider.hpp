#pragma once

#include <vector>

#include "world/physics/collision/speculative/hull_gap.hpp"
#include "world/physics/collision/speculative/speculative_contacts.hpp"
#include "world/physics/contacts/contact_cache.hpp"
#include "world/physics/contacts/part_collider.hpp"
#include "world/physics/model/physics_model.hpp"

namespace aprsim::physics {

inline constexpr std::size_t kPairCapacity = 64;  ///< contacts of a pair to reserve for

/// Narrow phase between bodies of the model: picks the exact geometry for a pair; ODE collides
/// the primitives of links. Contacts are appended to `out`, at most four points a surface. Depths
/// are those of the present poses; speculative contacts have negative depths. No call allocates
/// once `out` has its capacity.
class BodyCollider {
 public:
  // Least prediction distance of a closing pad, and of a body pressed on its support [m]. Contacts
  // then exist before they penetrate: a finger moves 0.3 mm in a step, a gear tips by less.
  static constexpr double kPadLookahead = 4e-4, kPressLookahead = 5e-5;

  explicit BodyCollider(const PhysicsModel& model);

  void free_on_free(int a, int b, std::vector<Contact>& out);
  /// Palm (0) or finger (1, 2) of a robot.
  void gripper_on_free(int robot, int part, int body, std::vector<Contact>& out) const;
  /// `link`: its id in the contacts.
  void link_on_free(const ArmShape& shape, BodyIndex link, int body, std::vector<Contact>& out);
  /// `shape`: its number among the fixed ones.
  void free_on_fixed(int body, int shape, std::vector<Contact>& out);
  void gripper_on_fixed(int robot, int part, const StaticShape& shape,
                        std::vector<Contact>& out) const;
  void gripper_on_link(int robot, int part, int other, const ArmShape& shape,
                       std::vector<Contact>& out);
  void gripper_on_gripper(int robot, int part, int other, int other_part,
                          std::vector<Contact>& out) const;

  /// Marks bodies that a gripper touches, by the contacts found so far. Trays under them are marked
  /// when their contacts are found. Marked bodies are predicted into their supports.
  void mark_pressed(const std::vector<ContactConstraint>& constraints);
  [[nodiscard]] bool is_pressed(int body) const {
    return pressed_[static_cast<std::size_t>(body)] != 0;
  }
  /// Contacts of pairs of free bodies, and of these on fixed shapes.
  [[nodiscard]] ContactCache& cache() { return cache_; }
  [[nodiscard]] const ContactCache& cache() const { return cache_; }

 private:
  [[nodiscard]] Displacement displacement_relative_to(const BodyVelocity& other,
                                                      const BodyVelocity& body) const;
  [[nodiscard]] double fall_towards(const Displacement& motion, const Eigen::Vector3d& n_W) const;
  [[nodiscard]] HullGap gap_between(const FreeBody& upper, const FreeBody& lower) const;
  /// A part of a gripper and a free body.
  struct PartOnBody {
    const GripperMechanism& hand;
    const FreeBody& free;
    int part;
    BodyIndex part_id;
    int body;
  };
  [[nodiscard]] Displacement part_displacement(const PartOnBody& pair, double least_m) const;
  [[nodiscard]] Displacement finger_displacement(const PartOnBody& pair) const;
  [[nodiscard]] Displacement cup_displacement(const PartOnBody& pair) const;
  void gripper_on_part(const PartOnBody& pair, std::vector<Contact>& out) const;
  void part_on_tray(const PartOnBody& pair, std::vector<Contact>& out) const;
  void part_on_tool(const PartOnBody& pair, std::vector<Contact>& out) const;
  void cup_on_tray(const PartOnBody& pair, std::vector<Contact>& out) const;
  void cup_on_gear(const PartOnBody& pair, std::vector<Contact>& out) const;
  void pad_on_gear(const PartOnBody& pair, std::vector<Contact>& out) const;
  void palm_on_gear(const PartOnBody& pair, std::vector<Contact>& out) const;
  [[nodiscard]] Displacement stopped_finger_displacement(const GripperMechanism& hand, int p,
                                                         const BodyVelocity& part) const;
  void press(int body) { pressed_[static_cast<std::size_t>(body)] = 1; }
  void tool_on_free(int tool, const Eigen::Isometry3d& D, int other,
                    std::vector<Contact>& out) const;
  [[nodiscard]] const GripperMechanism& gripper(int robot) const {
    return model_.grippers[static_cast<std::size_t>(robot)];
  }

  const PhysicsModel& model_;
  PartCollider parts_;
  ContactCache cache_;
  std::vector<char> pressed_;  // by body
  OdeGeom box_, cylinder_;     // of the present body
};

}  // namespace aprsim::physics
