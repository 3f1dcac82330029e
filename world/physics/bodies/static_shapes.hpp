#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "world/physics/bodies/free_body.hpp"
#include "world/physics/bodies/material_table.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::physics {

/// Something that never moves: a box, a piece of a fixture, the belt's slab, or the floor as a box
/// under z = 0.
struct StaticShape {
  std::string_view name;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  ///< of the box, or of that around the piece
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();
  Aabb bounds;
  bool belt = false;
  std::shared_ptr<const ConvexPiece> piece;  ///< its frame is S; none = the box itself
  int material = MaterialTable::kFixed;
  int first = -1;  ///< number of the first shape of the same thing

  [[nodiscard]] ConvexShape shape() const { return piece ? piece->shape() : box_shape(size); }
};

struct StaticShapes {
  std::vector<StaticShape> shapes;
  int belt = -1;                                           ///< index of the belt, -1 = none
  Eigen::Vector3d belt_axis_W = Eigen::Vector3d::UnitX();  ///< forward
  Eigen::Isometry3d X_CW = Eigen::Isometry3d::Identity();
  double belt_length_m = 0, belt_width_m = 0;

  /// True where the belt covers what lies beneath it: a frame whose top is level with the belt
  /// must not carry what stands on the belt.
  [[nodiscard]] bool under_belt(const Eigen::Vector3d& p_W) const;
};

[[nodiscard]] StaticShapes make_fixed_shapes(const scene::Scene& scene);

}  // namespace aprsim::physics
