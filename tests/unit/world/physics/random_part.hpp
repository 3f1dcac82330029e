#pragma once

#include <random>
#include <string>
#include <vector>

#include "world/scene/model/scene.hpp"

/// Parts of convex pieces in code, and random ones.
namespace aprsim::physics::test {

enum class PieceShape { kBox, kCylinder, kCone, kSphere, kCapsule, kPrism, kHull };
inline constexpr int kPieceShapes = 7;
[[nodiscard]] const char* name_of(PieceShape shape);

/// A random piece about its frame's origin that a sphere of this radius holds, none of its sizes
/// under a quarter of that.
[[nodiscard]] api::Piece random_piece(PieceShape shape, double radius_m, std::mt19937_64& random);

/// Corners of a regular polygon.
[[nodiscard]] std::vector<Eigen::Vector2d> regular_polygon(int corners, double radius_m);

/// The type of a part with these pieces.
[[nodiscard]] scene::PartType part_type(const std::string& name, std::vector<api::Piece> pieces,
                                        double mass_kg);
/// Adds the type if it is new, and a part of it.
void add_part(scene::Scene& scene, const std::string& name, const scene::PartType& type,
              const Pose& X_WP);
void add_fixture(scene::Scene& scene, const std::string& name, std::vector<api::Piece> pieces,
                 const Pose& X_WP = {});

}  // namespace aprsim::physics::test
