#pragma once

#include <vector>

#include <Eigen/Core>

#include "world/render/raster/tiles.hpp"
#include "world/scene/model/lens.hpp"

namespace aprsim::render {

/// The directions (x, y, 1) of all pixels of a camera, and their bounds.
struct Rays {
  struct Bounds {
    float x_min = 0, x_max = 0, y_min = 0, y_max = 0;
  };
  TileGrid grid;
  std::vector<float> x, y;                    ///< in the order of the grid
  std::vector<Bounds> tiles;                  ///< of each tile
  std::vector<Bounds> rows;                   ///< of each row of pixels within each tile
  std::vector<float> column_min, column_max;  ///< x in each column of tiles
  std::vector<float> row_min, row_max;        ///< y in each row of tiles

  /// Pixels whose direction the lens does not know see nothing.
  explicit Rays(const scene::Lens& lens);
};

}  // namespace aprsim::render
