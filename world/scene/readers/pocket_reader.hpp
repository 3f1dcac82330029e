#pragma once

#include "world/base/yaml/yaml_reader.hpp"
#include "world/scene/model/parts.hpp"

namespace aprsim::scene {

/// A pocket of a tray: round by two radii, or with walls along a rectangle or polygon. Rounded
/// corners of a rectangle become chords outside the arc, so that what fits the arc fits them.
[[nodiscard]] Pocket read_pocket(const yaml::Node& node);

/// The rectangle about the origin as an outline of at most Outline::kMaxCorners corners.
/// `corner_radius_m`: at most half of the shorter side.
[[nodiscard]] Outline rectangle_outline(const Eigen::Vector2d& size_m, double corner_radius_m);

}  // namespace aprsim::scene
