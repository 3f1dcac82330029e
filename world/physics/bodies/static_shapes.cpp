#include "world/physics/bodies/static_shapes.hpp"

#include <cmath>

namespace aprsim::physics {
namespace {

constexpr double kBeltThickness = 0.05;  // deep enough that nothing passes through in one step
constexpr double kFloorThickness = 1.0;
constexpr double kFloorExtent = 2e4;  // what rolls off the cell rolls far
constexpr double kBeltCover = 5e-3;   // a frame may lie this much under or over the belt's top

StaticShape make(std::string_view name, const Eigen::Vector3d& size,
                 const Eigen::Isometry3d& X_WS) {
  return {name, size, X_WS, aabb_of_box(size, X_WS), false};
}

}  // namespace

bool StaticShapes::under_belt(const Eigen::Vector3d& p_W) const {
  if (belt < 0) return false;
  const Eigen::Vector3d p_C = X_CW * p_W;
  return std::abs(p_C.x()) <= 0.5 * belt_length_m && std::abs(p_C.y()) <= 0.5 * belt_width_m &&
         std::abs(p_C.z()) <= kBeltCover;
}

StaticShapes make_fixed_shapes(const scene::Scene& scene) {
  StaticShapes fixed;
  for (const auto& box : scene.fixed) {
    fixed.shapes.push_back(make(box.name, box.size, box.X_WS.isometry()));
  }
  if (scene.conveyor) {
    const auto& conveyor = *scene.conveyor;
    const Eigen::Isometry3d X_WC = conveyor.X_WC.isometry();
    Eigen::Isometry3d X_WS = X_WC;
    // The conveyor frame lies in the belt's top face, the box's origin in its middle.
    X_WS.translation() -= 0.5 * kBeltThickness * X_WC.linear().col(2);
    fixed.belt = static_cast<int>(fixed.shapes.size());
    fixed.shapes.push_back(
        make("conveyor", {conveyor.length_m, conveyor.width_m, kBeltThickness}, X_WS));
    fixed.shapes.back().belt = true;
    fixed.belt_axis_W = X_WC.linear().col(0);
    fixed.X_CW = X_WC.inverse();
    fixed.belt_length_m = conveyor.length_m;
    fixed.belt_width_m = conveyor.width_m;
  }
  if (scene.floor) {
    Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();
    X_WS.translation().z() = -0.5 * kFloorThickness;
    fixed.shapes.push_back(make("floor", {kFloorExtent, kFloorExtent, kFloorThickness}, X_WS));
  }
  return fixed;
}

}  // namespace aprsim::physics
