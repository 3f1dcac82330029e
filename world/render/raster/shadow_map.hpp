#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "world/render/raster/depth_bounds.hpp"
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
/// width of a penumbra follows from the mean depth of what casts it (Fernando 2005). Depths near a
/// point are compared with the plane of its surface (Isidoro 2006).
class ShadowMap {
 public:
  /// A part of the map that a tile's points depend on, in tiles of the map.
  struct Range {
    int column_min = 0, column_max = -1, row_min = 0, row_max = -1;
  };

  /// Memory before anything is placed.
  [[nodiscard]] static std::uint64_t fixed_bytes();

  /// The map covers `lit`. The budget outlives it; fixed_bytes() have been taken from it.
  ShadowMap(const Lamp& lamp, const std::vector<Eigen::Vector3d>& lit, MemoryBudget& budget);

  /// As Rasterizer::draw; it does not move.
  void draw(const std::vector<Placement>& placements, int threads);
  /// Whether anything in the range has changed in the last draw().
  [[nodiscard]] bool changed(const Range& range) const;

  /// Writes which share of the lamp each point of a tile sees: 0 where it faces away. Returns the
  /// part of the map that this depends on.
  Range light(const TilePoints& points, TileValues& visible) const;
  [[nodiscard]] const Lamp& lamp() const { return lamp_; }

 private:
  Lamp lamp_;
  Eigen::Isometry3d X_LW_;
  float focal_ = 1;
  Rasterizer rasterizer_;
  TileSet changed_;
  DepthBounds bounds_;
  bool drawn_ = false;
};

}  // namespace aprsim::render
