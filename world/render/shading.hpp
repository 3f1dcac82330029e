#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "world/render/raster/rasterizer.hpp"
#include "world/render/raster/shadow_map.hpp"

namespace aprsim::render {

/// The lamps of a shader that count; further ones are dark.
inline constexpr std::size_t kMaxLamps = 4;

/// A camera's view of the placements that it has drawn.
struct View {
  const Rasterizer& raster;
  const std::vector<Placement>& placements;
  const std::vector<Eigen::Matrix3f>& R_WP;  ///< of the placements
  Eigen::Matrix3f R_WC;
  Eigen::Vector3f eye_W;
  Eigen::Vector2f pixel;  ///< size of a pixel in the directions
};

/// The surfaces that a tile's pixels show.
struct TileSurface {
  TilePoints points;
  TileValues red, green, blue;  ///< linear shares of the light
  TileValues gloss;             ///< negative where a pixel shows nothing
};

/// Finds the surfaces. Their patterns are averaged over the pixels.
void find_surface(const View& view, std::size_t tile, TileSurface& out);

/// Light from a tile's surfaces towards the eye: Lambert's law for the lamps and an even light from
/// above, and a gloss (Blinn 1977). Writes red, green and blue of all pixels of the tile;
/// `lit_from`: one a lamp.
void shade_tile(const TileSurface& surface, const Eigen::Vector3f& eye_W,
                const std::vector<ShadowMap>& lamps, float* rgb, ShadowMap::Range* lit_from);

}  // namespace aprsim::render
