#pragma once

#include <cstdint>
#include <vector>

#include "world/render/raster/tiles.hpp"

namespace aprsim::render {

/// Bounds of a square depth map by blocks, each about a plane of its own: the inverse depth of a
/// plane is linear in the map's pixels. Most pixels are nearer or farther than all of the map
/// nearby, and the bounds alone say so.
class DepthBounds {
 public:
  static constexpr int kBlock_px = 8;   ///< along a side
  static constexpr int kNear_px = 8;    ///< reach of the near bounds beyond a block
  static constexpr int kReach_px = 24;  ///< of the wide ones

  /// Inverse depths about a block: `middle` + `per_u` du + `per_v` dv, with (du, dv) from the
  /// block's middle, and bounds of what lies beside that within either reach.
  struct Block {
    float middle = 0, per_u = 0, per_v = 0;
    float near_low = 0, near_high = 0, low = 0, high = 0;
  };

  /// `size_px`: pixels along each side of the map, a multiple of the tiles' and of 64.
  explicit DepthBounds(int size_px);
  [[nodiscard]] static std::uint64_t bytes(int size_px);

  /// Takes over the tiles of the map that have changed.
  void update(const TileGrid& grid, const TileSet& changed, const float* depths);
  /// Row by row; blocks() along each side.
  [[nodiscard]] const Block* data() const { return blocks_.data(); }
  [[nodiscard]] int blocks() const { return blocks_along_; }

 private:
  // Each block alone, in rows with a margin that bounds nothing.
  struct Own {
    std::vector<float> middle, per_u, per_v, low, high;
  };
  void fit(const TileGrid& grid, const float* depths, int column, int row);
  void bound_row(int row);

  int blocks_along_;
  Own own_;
  std::vector<Block> blocks_;
};

}  // namespace aprsim::render
