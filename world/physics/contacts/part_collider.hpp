#pragma once

#include <vector>

#include "world/physics/collision/pairs/narrow_phase.hpp"
#include "world/physics/collision/pairs/piece_contacts.hpp"
#include "world/physics/model/physics_model.hpp"

namespace aprsim::physics {

/// Narrow phase of parts: unions of convex pieces against everything else. Appends contacts at the
/// given poses, normals into the first named body. Contacts that point out of one piece into
/// another one of the same body are left out, so that nothing is caught between pieces. No call
/// allocates after warm-up.
class PartCollider {
 public:
  explicit PartCollider(const PhysicsModel& model) : model_(model) {}

  /// `X_WB`: pose of the part; the other body, any free one, is where it is.
  void on_free(int part, const Eigen::Isometry3d& X_WB, int other, std::vector<Contact>& out) const;
  void on_fixed(int part, const Eigen::Isometry3d& X_WB, const StaticShape& shape,
                std::vector<Contact>& out) const;
  /// A shape of something else, which is the first body, on a part.
  void shape_on_part(const ConvexShape& shape, const Eigen::Isometry3d& X_WS, int part,
                     const ContactSides& sides, std::vector<Contact>& out) const;
  /// A finger's pad, which is the first body.
  void pad_on_part(const Pad& pad, const Eigen::Isometry3d& X_WD, int part,
                   const ContactSides& sides, std::vector<Contact>& out) const;

 private:
  const PhysicsModel& model_;
};

/// A primitive of an arm's link as a shape. `round` is filled in for a cylinder.
[[nodiscard]] ConvexShape shape_of_link(const ArmShape& link, detail::GearShape& round);

/// A free body, at the pose, against a shape that is not of parts: a gear, a tray or a tool.
void free_on_shape(const FreeBody& body, const Eigen::Isometry3d& X_WB, const ConvexShape& shape,
                   const Eigen::Isometry3d& X_WS, const ContactSides& sides,
                   std::vector<Contact>& out);

}  // namespace aprsim::physics
