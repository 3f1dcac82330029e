#include "world/physics/bodies/static_shapes.hpp"

#include <cmath>
#include <variant>

namespace aprsim::physics {
namespace {

constexpr double kBeltThickness = 0.05;  // deep enough that nothing passes through in one step
constexpr double kFloorThickness = 1.0;
constexpr double kFloorExtent = 2e4;  // what rolls off the cell rolls far
constexpr double kBeltCover = 5e-3;   // a frame may lie this much under or over the belt's top

StaticShape make(std::string_view name, const Eigen::Vector3d& size,
                 const Eigen::Isometry3d& X_WS) {
  StaticShape shape;
  shape.name = name;
  shape.size = size;
  shape.X_WS = X_WS;
  shape.bounds = aabb_of_box(size, X_WS);
  return shape;
}

/// A box is the same as a fixed box, for which everything has its fastest way.
StaticShape make(const scene::Fixture& fixture, const api::Piece& piece) {
  const ConvexPiece prepared(piece);
  const Eigen::Isometry3d X_WS = fixture.X_WP.isometry() * prepared.X_BP();
  StaticShape shape = make(fixture.name, prepared.size(), X_WS);
  if (std::holds_alternative<api::BoxPiece>(piece.shape)) return shape;
  shape.piece = std::make_shared<ConvexPiece>(prepared);
  shape.bounds = prepared.bounds(X_WS);
  return shape;
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
  const MaterialTable materials(scene);
  for (const auto& fixture : scene.fixtures) {
    const int first = static_cast<int>(fixed.shapes.size());
    for (const auto& piece : fixture.pieces) {
      fixed.shapes.push_back(make(fixture, piece));
      fixed.shapes.back().material = materials.number_of(fixture.material);
    }
    for (std::size_t i = static_cast<std::size_t>(first); i < fixed.shapes.size(); ++i) {
      fixed.shapes[i].first = first;
    }
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
    fixed.shapes.back().material = MaterialTable::kBelt;
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
  for (std::size_t i = 0; i < fixed.shapes.size(); ++i) {
    StaticShape& shape = fixed.shapes[i];
    if (shape.first < 0) shape.first = static_cast<int>(i);
  }
  return fixed;
}

}  // namespace aprsim::physics
