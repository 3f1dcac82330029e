#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "world/physics/bodies/free_body.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::physics {

/// Something that never moves: a box, the belt's slab, or the floor as a box under z = 0.
struct StaticShape {
  std::string_view name;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();
  Aabb bounds;
  bool belt = false;
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
