#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace aprsim::render {

/// Pixels of a picture in tiles, each tile's side by side in memory. Pixels beyond the picture's
/// right and lower edge fill its last tiles.
struct TileGrid {
  static constexpr int kWidth = 32, kHeight = 16, kPixels = kWidth * kHeight;

  int width = 0, height = 0;  ///< of the picture
  int columns = 0, rows = 0;  ///< of tiles

  TileGrid(int width_px, int height_px)
      : width(width_px),
        height(height_px),
        columns((width_px + kWidth - 1) / kWidth),
        rows((height_px + kHeight - 1) / kHeight) {}

  [[nodiscard]] std::size_t tiles() const { return static_cast<std::size_t>(columns * rows); }
  [[nodiscard]] std::size_t pixels() const { return tiles() * kPixels; }
  [[nodiscard]] std::size_t tile_at(int column, int row) const {
    return static_cast<std::size_t>(row * columns + column);
  }
  /// Place of a pixel in arrays of pixels().
  [[nodiscard]] std::size_t index(int x, int y) const {
    const std::size_t tile = tile_at(x / kWidth, y / kHeight);
    return tile * kPixels + static_cast<std::size_t>((y % kHeight) * kWidth + x % kWidth);
  }
};

/// A number of each pixel of a tile.
struct alignas(32) TileValues : std::array<float, TileGrid::kPixels> {};

/// The points that a tile's pixels show, in the world, and unit normals of their surfaces.
struct TilePoints {
  TileValues x, y, z, normal_x, normal_y, normal_z;
};

/// A set of tiles.
using TileSet = std::vector<std::uint8_t>;

inline void unite(TileSet& into, const TileSet& other) {
  for (std::size_t i = 0; i < into.size(); ++i) into[i] |= other[i];
}

}  // namespace aprsim::render
