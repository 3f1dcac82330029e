#include "tests/unit/world/physics/random_part.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "world/scene/model/pieces.hpp"

namespace aprsim::physics::test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double between(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

std::vector<Vector2d> random_polygon(double radius_m, std::mt19937_64& random) {
  const int count = 3 + static_cast<int>(between(random, 0, 7.9));
  const double wide = between(random, 0.5, 1) * radius_m, high = between(random, 0.5, 1) * radius_m;
  std::vector<Vector2d> corners;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * (i + between(random, -0.3, 0.3)) / count;
    corners.emplace_back(wide * std::cos(angle), high * std::sin(angle));
  }
  return corners;
}

}  // namespace

const char* name_of(PieceShape shape) {
  constexpr const char* kNames[] = {"box",     "cylinder", "cone", "sphere",
                                    "capsule", "prism",    "hull"};
  return kNames[static_cast<int>(shape)];
}

api::Piece random_piece(PieceShape shape, double radius_m, std::mt19937_64& random) {
  const double r = radius_m, third = r / std::sqrt(3.0);
  const auto size = [&](double most) { return between(random, 0.5, 1) * most; };
  switch (shape) {
    case PieceShape::kBox:
      return {api::BoxPiece{{size(2 * third), size(2 * third), size(2 * third)}}, {}};
    case PieceShape::kCylinder: {
      const double wide = size(0.7 * r);
      return {api::ConePiece{wide, wide, size(1.4 * r)}, {}};
    }
    case PieceShape::kCone:
      return {api::ConePiece{size(0.7 * r), size(0.4 * r), size(1.4 * r)}, {}};
    case PieceShape::kSphere:
      return {api::CapsulePiece{size(r), 0}, {}};
    case PieceShape::kCapsule:
      return {api::CapsulePiece{size(0.5 * r), size(r)}, {}};
    case PieceShape::kPrism:
      return {api::PrismPiece{random_polygon(0.7 * r, random), size(1.4 * r)}, {}};
    case PieceShape::kHull:
      break;
  }
  std::normal_distribution<double> normal;
  std::vector<Vector3d> points;
  const int count = 8 + static_cast<int>(between(random, 0, 16));
  for (int i = 0; i < count; ++i) {
    points.push_back(r * Vector3d(normal(random), normal(random), normal(random)).normalized());
  }
  return {scene::hull_of(points), {}};
}

std::vector<Vector2d> regular_polygon(int corners, double radius_m) {
  std::vector<Vector2d> out;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    out.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle));
  }
  return out;
}

scene::PartType part_type(const std::string& name, std::vector<api::Piece> pieces, double mass_kg) {
  scene::PartType type;
  type.name = name;
  type.pieces = std::move(pieces);
  const scene::UnitMass unit = scene::unit_mass_of(type.pieces);
  type.mass_kg = mass_kg;
  type.com = unit.com;
  type.inertia = mass_kg / unit.volume_m3 * unit.inertia;
  type.material = scene::kGearMaterial;
  return type;
}

void add_part(scene::Scene& scene, const std::string& name, const scene::PartType& type,
              const Pose& X_WP) {
  scene.part_types.emplace(type.name, type);
  scene.parts.push_back({name, type.name, X_WP});
}

void add_fixture(scene::Scene& scene, const std::string& name, std::vector<api::Piece> pieces,
                 const Pose& X_WP) {
  scene.fixtures.push_back({name, std::move(pieces), X_WP, scene::kFixedMaterial});
}

}  // namespace aprsim::physics::test
