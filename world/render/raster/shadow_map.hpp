#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "world/render/raster/rasterizer.hpp"

namespace aprsim::render {

/// A round lamp.
struct Lamp {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  double radius_m = 0.05;
  float brightness = 1;  ///< of what faces it at `distance_m`, white
  double distance_m = 2.5;
};

/// The light of a lamp. Depths as the lamp sees them tell what is in shadow (Williams 1978); the
/// width of a penumbra follows from the mean depth of what casts it (Fernando 2005).
class ShadowMap {
 public:
  /// A part of the map that a tile's points depend on, in tiles of the map.
  struct Range {
    int column_min = 0, column_max = -1, row_min = 0, row_max = -1;
  };
  /// Collects the range of several points.
  struct Spread {
    float u_min = 1e9F, u_max = -1e9F, v_min = 1e9F, v_max = -1e9F;
  };

  /// Memory before anything is placed.
  [[nodiscard]] static std::uint64_t fixed_bytes();

  /// The map covers `lit`. The budget outlives it; fixed_bytes() have been taken from it.
  ShadowMap(const Lamp& lamp, const std::vector<Eigen::Vector3d>& lit, MemoryBudget& budget);

  /// As Rasterizer::draw; it does not move.
  void draw(const std::vector<Placement>& placements, int threads);
  /// Whether anything in the range has changed in the last draw().
  [[nodiscard]] bool changed(const Range& range) const;
  [[nodiscard]] Range range(const Spread& spread) const;

  /// Share of the lamp that a point with this normal sees. `pattern`: 0 to 15, alternates the
  /// samples of neighbouring pixels. Adds the point to `spread`.
  [[nodiscard]] float visibility(const Eigen::Vector3f& p_W, const Eigen::Vector3f& normal_W,
                                 int pattern, Spread& spread) const;
  [[nodiscard]] const Lamp& lamp() const { return lamp_; }

 private:
  void bound_depths();
  [[nodiscard]] float inverse_depth(float u, float v) const;

  Lamp lamp_;
  Eigen::Isometry3d X_LW_;
  Eigen::Isometry3f X_LW_f_;
  float focal_ = 1;
  Rasterizer rasterizer_;
  TileSet changed_;
  // Square blocks of pixels: bounds of the inverse depths there, then of those within reach.
  std::vector<float> least_, most_, least_near_, most_near_;
};

}  // namespace aprsim::render
