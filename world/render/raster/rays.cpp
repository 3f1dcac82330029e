#include "world/render/raster/rays.hpp"

#include <algorithm>
#include <limits>

namespace aprsim::render {
namespace {

constexpr float kUnbounded = std::numeric_limits<float>::infinity();
constexpr Rays::Bounds kNothing = {kUnbounded, -kUnbounded, kUnbounded, -kUnbounded};

void include(Rays::Bounds& bounds, float x, float y) {
  bounds.x_min = std::min(bounds.x_min, x);
  bounds.x_max = std::max(bounds.x_max, x);
  bounds.y_min = std::min(bounds.y_min, y);
  bounds.y_max = std::max(bounds.y_max, y);
}

}  // namespace

Rays::Rays(const scene::Lens& lens)
    : grid(lens.width_px, lens.height_px),
      x(grid.pixels(), std::numeric_limits<float>::quiet_NaN()),
      y(grid.pixels(), std::numeric_limits<float>::quiet_NaN()),
      tiles(grid.tiles(), kNothing),
      rows(grid.tiles() * TileGrid::kHeight, kNothing),
      column_min(static_cast<std::size_t>(grid.columns), kUnbounded),
      column_max(static_cast<std::size_t>(grid.columns), -kUnbounded),
      row_min(static_cast<std::size_t>(grid.rows), kUnbounded),
      row_max(static_cast<std::size_t>(grid.rows), -kUnbounded) {
  for (int v = 0; v < grid.height; ++v) {
    for (int u = 0; u < grid.width; ++u) {
      const auto direction = lens.direction({u, v});
      if (!direction) continue;
      const std::size_t i = grid.index(u, v), tile = i / TileGrid::kPixels;
      x[i] = static_cast<float>(direction->x());
      y[i] = static_cast<float>(direction->y());
      include(tiles[tile], x[i], y[i]);
      include(rows[i / TileGrid::kWidth], x[i], y[i]);
    }
  }
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const Bounds& tile = tiles[grid.tile_at(column, row)];
      const auto c = static_cast<std::size_t>(column), r = static_cast<std::size_t>(row);
      column_min[c] = std::min(column_min[c], tile.x_min);
      column_max[c] = std::max(column_max[c], tile.x_max);
      row_min[r] = std::min(row_min[r], tile.y_min);
      row_max[r] = std::max(row_max[r], tile.y_max);
    }
  }
}

}  // namespace aprsim::render
