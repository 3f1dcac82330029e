#pragma once

#include <vector>

#include "world/render/mesh/material.hpp"
#include "world/render/raster/rasterizer.hpp"
#include "world/render/raster/shadow_map.hpp"

namespace aprsim::render {

/// A point of a surface as a pixel shows it.
struct SurfacePoint {
  Eigen::Vector3f p_W, normal_W;
  Eigen::Vector3f to_eye_W;      ///< unit vector
  Eigen::Vector2f at;            ///< in the mesh's x-y plane [m]
  Eigen::Vector2f per_x, per_y;  ///< its changes from pixel to pixel
  const Material* material = nullptr;
  float phase_m = 0;  ///< of a moving pattern along x
};

/// Colour of the surface itself at a point; its pattern averaged over the pixel.
[[nodiscard]] Eigen::Vector3f surface_colour(const SurfacePoint& point);

/// Light from the point towards the eye: Lambert's law for the lamps and an even light from above,
/// and a gloss (Blinn 1977). `spreads`: one a lamp.
[[nodiscard]] Eigen::Vector3f shade(const SurfacePoint& point, const std::vector<ShadowMap>& lamps,
                                    int pattern, ShadowMap::Spread* spreads);

}  // namespace aprsim::render
