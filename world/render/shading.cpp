#include "world/render/shading.hpp"

#include <algorithm>
#include <cmath>

#include "world/render/mesh/aruco.hpp"

namespace aprsim::render {
namespace {

constexpr float kHolePitch_m = 0.0254F, kHoleRadius_m = 0.0032F;
constexpr float kStripePitch_m = 0.24F, kStripe_m = 0.02F;
constexpr float kGrid_m = 1, kLine_m = 0.01F;
constexpr float kEven = 0.34F, kFromAbove = 0.14F;  // light from everywhere

/// Distance from the nearest multiple of `pitch`.
float off_multiple(float x, float pitch) { return std::abs(x - pitch * std::round(x / pitch)); }

bool is_second(const Material& material, const Eigen::Vector2f& at, float phase_m) {
  switch (material.pattern) {
    case Pattern::kPlain:
      return false;
    case Pattern::kMarker: {
      // The first row is the one at +y.
      const Eigen::Vector2f share =
          (at - material.marker_centre) / material.marker_size_m + Eigen::Vector2f(0.5F, 0.5F);
      const int column = static_cast<int>(std::floor(share.x() * kMarkerCells));
      const int row = static_cast<int>(std::floor((1 - share.y()) * kMarkerCells));
      const bool inside = column >= 0 && row >= 0 && column < kMarkerCells && row < kMarkerCells;
      return inside && !marker_is_white(material.marker, row, column);
    }
    case Pattern::kHoles: {
      const Eigen::Vector2f off(off_multiple(at.x(), kHolePitch_m),
                                off_multiple(at.y(), kHolePitch_m));
      return off.squaredNorm() < kHoleRadius_m * kHoleRadius_m;
    }
    case Pattern::kBelt:
      return off_multiple(at.x() - phase_m, kStripePitch_m) < kStripe_m;
    case Pattern::kGrid:
      return std::min(off_multiple(at.x(), kGrid_m), off_multiple(at.y(), kGrid_m)) < kLine_m;
  }
  return false;
}

/// x^64.
float sharpen(float x) {
  for (int i = 0; i < 6; ++i) x *= x;
  return x;
}

}  // namespace

Eigen::Vector3f surface_colour(const SurfacePoint& point) {
  const Material& material = *point.material;
  if (material.pattern == Pattern::kPlain) return material.colour;
  int second = 0;
  constexpr int kSide = 3;  // samples along each side of a pixel
  for (int i = 0; i < kSide * kSide; ++i) {
    const float x = (static_cast<float>(i % kSide) + 0.5F) / kSide - 0.5F;
    const float y = (static_cast<float>(i / kSide) + 0.5F) / kSide - 0.5F;
    second += is_second(material, point.at + x * point.per_x + y * point.per_y, point.phase_m);
  }
  const float share = static_cast<float>(second) / (kSide * kSide);
  return (1 - share) * material.colour + share * material.second;
}

Eigen::Vector3f shade(const SurfacePoint& point, const std::vector<ShadowMap>& lamps, int pattern,
                      ShadowMap::Spread* spreads) {
  float diffuse = kEven + kFromAbove * point.normal_W.z(), gloss = 0;
  for (std::size_t i = 0; i < lamps.size(); ++i) {
    const Lamp& lamp = lamps[i].lamp();
    const Eigen::Vector3f to_lamp = lamp.p_W.cast<float>() - point.p_W;
    const float distance = to_lamp.norm();
    const Eigen::Vector3f l = to_lamp / distance;
    const float slope = point.normal_W.dot(l);
    if (!(slope > 0)) continue;
    const float farther = distance / static_cast<float>(lamp.distance_m);
    const float light = lamp.brightness / (farther * farther) *
                        lamps[i].visibility(point.p_W, point.normal_W, pattern, spreads[i]);
    diffuse += light * slope;
    gloss += light * sharpen(std::max(0.0F, point.normal_W.dot((l + point.to_eye_W).normalized())));
  }
  return diffuse * surface_colour(point) +
         Eigen::Vector3f::Constant(8 * point.material->gloss * gloss);
}

}  // namespace aprsim::render
