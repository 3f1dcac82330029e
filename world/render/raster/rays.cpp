#include "world/render/raster/rays.hpp"

#include <algorithm>
#include <limits>

namespace aprsim::render {
namespace {

constexpr float kUnbounded = std::numeric_limits<float>::infinity();
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr Rays::Bounds kNothing = {kUnbounded, -kUnbounded, kUnbounded, -kUnbounded};

void include(Rays::Bounds& bounds, float x, float y) {
  bounds.x_min = std::min(bounds.x_min, x);
  bounds.x_max = std::max(bounds.x_max, x);
  bounds.y_min = std::min(bounds.y_min, y);
  bounds.y_max = std::max(bounds.y_max, y);
}

bool is_distorted(const scene::Lens& lens) {
  return std::ranges::any_of(lens.distortion, [](double term) { return term != 0; });
}

}  // namespace

std::uint64_t Rays::bytes(const scene::Lens& lens) {
  const TileGrid grid(lens.width_px, lens.height_px);
  const auto edges =
      static_cast<std::uint64_t>(grid.columns * TileGrid::kWidth + grid.rows * TileGrid::kHeight);
  return grid.tiles() * (1 + TileGrid::kHeight) * sizeof(Bounds) + 2 * edges * sizeof(float) +
         (is_distorted(lens) ? 2 * grid.pixels() * sizeof(float) : 0);
}

Rays::Rays(const scene::Lens& lens)
    : grid(lens.width_px, lens.height_px),
      tiles(grid.tiles(), kNothing),
      rows(grid.tiles() * TileGrid::kHeight, kNothing),
      column_min(static_cast<std::size_t>(grid.columns), kUnbounded),
      column_max(static_cast<std::size_t>(grid.columns), -kUnbounded),
      row_min(static_cast<std::size_t>(grid.rows), kUnbounded),
      row_max(static_cast<std::size_t>(grid.rows), -kUnbounded) {
  is_distorted_ = is_distorted(lens);
  if (is_distorted_) {
    store_pixels(lens);
  } else {
    store_columns_and_rows(lens);
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

void Rays::store_pixels(const scene::Lens& lens) {
  x_.assign(grid.pixels(), kUnknown);
  y_.assign(grid.pixels(), kUnknown);
  for (int v = 0; v < grid.height; ++v) {
    for (int u = 0; u < grid.width; ++u) {
      const auto direction = lens.direction({u, v});
      if (!direction) continue;
      const std::size_t i = grid.index(u, v);
      x_[i] = static_cast<float>(direction->x());
      y_[i] = static_cast<float>(direction->y());
      include(tiles[i / TileGrid::kPixels], x_[i], y_[i]);
      include(rows[i / TileGrid::kWidth], x_[i], y_[i]);
    }
  }
}

void Rays::store_columns_and_rows(const scene::Lens& lens) {
  x_.assign(static_cast<std::size_t>(grid.columns * TileGrid::kWidth), kUnknown);
  y_.assign(static_cast<std::size_t>(grid.rows * TileGrid::kHeight), kUnknown);
  const auto direction = [&lens](int u, int v) -> Eigen::Vector2f {
    return lens.direction({u, v}).value().cast<float>();
  };
  for (int u = 0; u < grid.width; ++u) x_[static_cast<std::size_t>(u)] = direction(u, 0).x();
  for (int v = 0; v < grid.height; ++v) y_[static_cast<std::size_t>(v)] = direction(0, v).y();
  // Directions grow from pixel to pixel: the ends of a row of a tile are its bounds.
  for (int v = 0; v < grid.height; ++v) {
    for (int u0 = 0; u0 < grid.width; u0 += TileGrid::kWidth) {
      const int u1 = std::min(u0 + TileGrid::kWidth, grid.width) - 1;
      const std::size_t i = grid.index(u0, v);
      for (const int u : {u0, u1}) {
        const float x = x_[static_cast<std::size_t>(u)], y = y_[static_cast<std::size_t>(v)];
        include(tiles[i / TileGrid::kPixels], x, y);
        include(rows[i / TileGrid::kWidth], x, y);
      }
    }
  }
}

Eigen::Vector3f Rays::at(std::size_t pixel) const {
  if (is_distorted_) return {x_[pixel], y_[pixel], 1};
  const std::size_t tile = pixel / TileGrid::kPixels, place = pixel % TileGrid::kPixels;
  const auto columns = static_cast<std::size_t>(grid.columns);
  return {x_[tile % columns * TileGrid::kWidth + place % TileGrid::kWidth],
          y_[tile / columns * TileGrid::kHeight + place / TileGrid::kWidth], 1};
}

void Rays::copy_tile(std::size_t tile, float* x, float* y) const {
  if (is_distorted_) {
    std::copy_n(x_.data() + tile * TileGrid::kPixels, TileGrid::kPixels, x);
    std::copy_n(y_.data() + tile * TileGrid::kPixels, TileGrid::kPixels, y);
    return;
  }
  const auto columns = static_cast<std::size_t>(grid.columns);
  const float* const across = x_.data() + tile % columns * TileGrid::kWidth;
  const float* const down = y_.data() + tile / columns * TileGrid::kHeight;
  for (int row = 0; row < TileGrid::kHeight; ++row) {
    std::copy_n(across, TileGrid::kWidth, x + row * TileGrid::kWidth);
    std::fill_n(y + row * TileGrid::kWidth, TileGrid::kWidth, down[row]);
  }
}

}  // namespace aprsim::render
