#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "world/render/mesh/mesh.hpp"
#include "world/render/raster/memory_budget.hpp"
#include "world/render/raster/rays.hpp"

namespace aprsim::render {

/// A mesh somewhere in the world.
struct Placement {
  const Mesh* mesh = nullptr;
  Eigen::Isometry3d X_W = Eigen::Isometry3d::Identity();
  double phase_m = 0;  ///< of its moving pattern

  /// Whether both look the same.
  [[nodiscard]] bool same(const Placement& other) const {
    return mesh == other.mesh && X_W.matrix() == other.X_W.matrix() && phase_m == other.phase_m;
  }
};

/// Finds the nearest surface of every pixel. A triangle with corners a, b, c in the camera frame is
/// seen in the direction r where the planes through the eye and its edges have r on their inner
/// side: (c x b) r, (a x c) r and (b x a) r >= 0 (homogeneous rasterisation, Olano and Greer 1997).
/// Directions come from a table, so every lens is exact. Only tiles over which a placement has
/// changed are drawn again; a tile's bits depend on nothing but the placements.
class Rasterizer {
 public:
  /// A triangle as one camera sees it.
  struct Facet {
    Eigen::Vector3f edge[3];  ///< planes through the eye, opposite the corners
    Eigen::Vector3f inverse;  ///< its product with a direction is 1 / depth
    float x_min = 0, x_max = 0, y_min = 0, y_max = 0;  ///< of the directions that meet it
    std::uint32_t triangle = 0;                        ///< index into the mesh
  };
  static constexpr std::uint32_t kNothing = 0xffffffff;
  static constexpr unsigned kFacetBits = 20;

  enum class Contents { kDepth, kDepthAndOwner };

  /// The budget outlives it. Its fixed_bytes() have been taken from it, and are not checked.
  Rasterizer(const scene::Lens& lens, Contents contents, MemoryBudget& budget);
  /// Memory before anything is placed.
  [[nodiscard]] static std::uint64_t fixed_bytes(const scene::Lens& lens, Contents contents);

  /// Draws the tiles that have changed since the last call, and says which: all where the camera
  /// has moved. `X_CW`: the world in the camera frame; placements keep their order. Where the
  /// budget is exceeded the picture is incomplete, and the rasterizer of no more use.
  const TileSet& draw(const std::vector<Placement>& placements, const Eigen::Isometry3d& X_CW,
                      int threads);

  [[nodiscard]] const Rays& rays() const { return rays_; }
  /// 1 / depth of every pixel, 0 = nothing there.
  [[nodiscard]] const std::vector<float>& inverse_depth() const { return inverse_depth_; }
  /// Owner of every pixel: placement << kFacetBits | facet. Empty with the depth alone.
  [[nodiscard]] const std::vector<std::uint32_t>& owner() const { return owner_; }
  [[nodiscard]] const Facet& facet(std::uint32_t owner) const {
    return placed_[owner >> kFacetBits].facets[owner & ((1U << kFacetBits) - 1)];
  }

 private:
  struct Placed {
    Placement at;
    bool drawn = false;
    std::vector<Facet> facets;
    std::vector<std::uint32_t> begin;  ///< of each tile's share in `facet_of_tile`, one more
    std::vector<std::uint32_t> facet_of_tile;
    TileSet tiles;
  };

  // False where the budget is exceeded.
  bool place(Placed& placed, const Placement& at, const Eigen::Isometry3d& X_CW);
  bool sort_into_tiles(Placed& placed);
  bool add_meeting(std::size_t tile, std::size_t facet);
  void draw_tile(std::size_t tile);

  MemoryBudget& budget_;
  Rays rays_;
  Eigen::Isometry3d X_CW_ = Eigen::Isometry3d::Identity();
  std::vector<Placed> placed_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> meetings_;  // tile, facet; of one placement
  std::vector<float> inverse_depth_;
  std::vector<std::uint32_t> owner_;
  TileSet changed_;
};

}  // namespace aprsim::render
