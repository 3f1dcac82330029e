#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

namespace aprsim::render {

/// Triangles, anticlockwise, that cover a plane polygon with holes. The outline runs anticlockwise,
/// holes run clockwise; they do not meet. Cuts off ears (Meisters 1975) after each hole has been
/// joined to the outline by its shortest free bridge.
[[nodiscard]] std::vector<std::array<Eigen::Vector2d, 3>> triangulate(
    const std::vector<Eigen::Vector2d>& outline,
    const std::vector<std::vector<Eigen::Vector2d>>& holes);

}  // namespace aprsim::render
