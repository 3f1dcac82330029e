#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "world/render/raster/tiles.hpp"
#include "world/scene/model/lens.hpp"

namespace aprsim::render {

/// The directions (x, y, 1) of all pixels of a camera, and their bounds. Pixels whose direction the
/// lens does not know see nothing.
class Rays {
 public:
  struct Bounds {
    float x_min = 0, x_max = 0, y_min = 0, y_max = 0;
  };
  TileGrid grid;
  std::vector<Bounds> tiles;                  ///< of each tile
  std::vector<Bounds> rows;                   ///< of each row of pixels within each tile
  std::vector<float> column_min, column_max;  ///< x in each column of tiles
  std::vector<float> row_min, row_max;        ///< y in each row of tiles

  explicit Rays(const scene::Lens& lens);
  /// Memory of the directions of such a lens.
  [[nodiscard]] static std::uint64_t bytes(const scene::Lens& lens);

  /// Direction of a pixel by its place in the grid.
  [[nodiscard]] Eigen::Vector3f at(std::size_t pixel) const;
  /// Writes the directions of a tile's pixels.
  void copy_tile(std::size_t tile, float* x, float* y) const;

 private:
  void store_pixels(const scene::Lens& lens);
  void store_columns_and_rows(const scene::Lens& lens);

  // In the order of the grid; without distortion of each column and of each row alone.
  std::vector<float> x_, y_;
  bool is_distorted_ = false;
};

}  // namespace aprsim::render
