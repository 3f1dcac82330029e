#include "world/render/shading.hpp"

#include <algorithm>
#include <array>

#include "world/base/simd/vec8f.hpp"
#include "world/base/simd/vector_clones.hpp"
#include "world/render/mesh/pattern.hpp"

namespace aprsim::render {
namespace {

constexpr float kEven = 0.34F, kFromAbove = 0.14F;  // light from everywhere
constexpr float kBackground = 0.18F, kNoSurface = -1;

/// A facet with all that its pixels share.
struct FacetSurface {
  std::uint32_t owner = Rasterizer::kNothing;
  const Rasterizer::Facet* facet = nullptr;
  const Mesh::Triangle* triangle = nullptr;
  const Material* material = nullptr;
  std::array<Eigen::Vector3f, 3> normals_W;
  MarkerCells cells{};
  float phase_m = 0;
};

FacetSurface facet_surface(const View& view, std::uint32_t owner) {
  FacetSurface out;
  const std::size_t place = owner >> Rasterizer::kFacetBits;
  const Placement& placement = view.placements[place];
  out.owner = owner;
  out.facet = &view.raster.facet(owner);
  out.triangle = &placement.mesh->triangles[out.facet->triangle];
  out.material = &placement.mesh->materials[static_cast<std::size_t>(out.triangle->material)];
  for (std::size_t i = 0; i < 3; ++i)
    out.normals_W[i] = view.R_WP[place] * out.triangle->normals[i];
  out.cells = marker_cells(*out.material);
  out.phase_m = static_cast<float>(placement.phase_m);
  return out;
}

/// Weights of a facet's corners where directions meet it.
inline Vector3x8 weights(const Rasterizer::Facet& facet, const Vec8f& x, const Vec8f& y) {
  const auto side = [&](const Eigen::Vector3f& edge) -> Vec8f {
    return edge.x() * x + edge.y() * y + edge.z();
  };
  const Vector3x8 w{side(facet.edge[0]), side(facet.edge[1]), side(facet.edge[2])};
  return w * (1 / (w.x + w.y + w.z));
}

/// A value that facets have at their corners.
inline Vector3x8 blend(const std::array<Eigen::Vector3f, 3>& corners, const Vector3x8& w) {
  return Vector3x8::broadcast(corners[0]) * w.x + Vector3x8::broadcast(corners[1]) * w.y +
         Vector3x8::broadcast(corners[2]) * w.z;
}

/// Share of the material's second colour in each pixel.
inline Vec8f second_share(const FacetSurface& surface, const Eigen::Vector2f& pixel, const Vec8f& x,
                          const Vec8f& y) {
  const auto place = [&surface](const Vec8f& u, const Vec8f& v) {
    return blend(surface.triangle->points, weights(*surface.facet, u, v));
  };
  const Vector3x8 at = place(x, y);
  const Vector3x8 per_x = place(x + pixel.x(), y) - at, per_y = place(x, y + pixel.y()) - at;
  constexpr int kSamples = 3;  // along each side of a pixel
  Vec8i seconds = broadcast(0);
  for (int i = 0; i < kSamples * kSamples; ++i) {
    const float u = (static_cast<float>(i % kSamples) + 0.5F) / kSamples - 0.5F;
    const float v = (static_cast<float>(i / kSamples) + 0.5F) / kSamples - 0.5F;
    seconds -= has_second(*surface.material, surface.cells, at.x + u * per_x.x + v * per_y.x,
                          at.y + u * per_x.y + v * per_y.y, surface.phase_m);
  }
  return to_float(seconds) * (1.0F / (kSamples * kSamples));
}

/// Eight pixels of a tile while their facets are looked at.
struct Pixels {
  Vec8f x, y;  // directions
  Vector3x8 normal;
  Vec8f red, green, blue, gloss;
};

inline void put(const FacetSurface& surface, const Mask8& mine, const Eigen::Vector2f& pixel,
                Pixels& out) {
  const Vector3x8 normal =
      blend(surface.normals_W, weights(*surface.facet, out.x, out.y)).normalized();
  out.normal.x = mine ? normal.x : out.normal.x;
  out.normal.y = mine ? normal.y : out.normal.y;
  out.normal.z = mine ? normal.z : out.normal.z;
  const Material& material = *surface.material;
  const Vec8f share = material.pattern == Pattern::kPlain
                          ? broadcast(0.0F)
                          : second_share(surface, pixel, out.x, out.y);
  const auto mix = [&](Eigen::Index i) -> Vec8f {
    return material.colour[i] + (material.second[i] - material.colour[i]) * share;
  };
  out.red = mine ? mix(0) : out.red;
  out.green = mine ? mix(1) : out.green;
  out.blue = mine ? mix(2) : out.blue;
  out.gloss = mine ? broadcast(material.gloss) : out.gloss;
}

/// `owners`: of the tile's pixels.
APRSIM_VECTOR_CLONES void find_pixels(const View& view, const std::uint32_t* owners,
                                      const float* depths, const TileValues& x, const TileValues& y,
                                      TileSurface& out) {
  FacetSurface surface;
  for (int i = 0; i < TileGrid::kPixels; i += kLanes) {
    Pixels pixels{
        load(&x[i]),          load(&y[i]),     Vector3x8::broadcast(Eigen::Vector3f::UnitZ()),
        broadcast(0.0F),      broadcast(0.0F), broadcast(0.0F),
        broadcast(kNoSurface)};
    Vec8u owner;
    std::memcpy(&owner, owners + i, sizeof owner);
    const Mask8 shown = owner != Rasterizer::kNothing;
    Mask8 rest = shown;
    for (int lane = 0; lane < kLanes; ++lane) {
      if (rest[lane] == 0) continue;
      if (surface.owner != owner[lane]) surface = facet_surface(view, owner[lane]);
      const Mask8 mine = owner == owner[lane];
      put(surface, mine, view.pixel, pixels);
      rest &= ~mine;
      if (!any(rest)) break;
    }
    const Vec8f depth = 1 / (shown ? load(depths + i) : broadcast(1.0F));
    const Vector3x8 p = Vector3x8::broadcast(view.eye_W) +
                        view.R_WC * Vector3x8{pixels.x, pixels.y, broadcast(1.0F)} * depth;
    store(&out.points.x[i], p.x);
    store(&out.points.y[i], p.y);
    store(&out.points.z[i], p.z);
    store(&out.points.normal_x[i], pixels.normal.x);
    store(&out.points.normal_y[i], pixels.normal.y);
    store(&out.points.normal_z[i], pixels.normal.z);
    store(&out.red[i], pixels.red);
    store(&out.green[i], pixels.green);
    store(&out.blue[i], pixels.blue);
    store(&out.gloss[i], pixels.gloss);
  }
}

/// x^64.
inline Vec8f sharpen(Vec8f x) {
  for (int i = 0; i < 6; ++i) x *= x;
  return x;
}

APRSIM_VECTOR_CLONES void shade_pixels(const TileSurface& surface, const Eigen::Vector3f& eye_W,
                                       const std::vector<ShadowMap>& lamps,
                                       const std::array<TileValues, kMaxLamps>& visible,
                                       float* rgb) {
  const TilePoints& points = surface.points;
  for (int i = 0; i < TileGrid::kPixels; i += kLanes) {
    const Vector3x8 p{load(&points.x[i]), load(&points.y[i]), load(&points.z[i])};
    const Vector3x8 normal{load(&points.normal_x[i]), load(&points.normal_y[i]),
                           load(&points.normal_z[i])};
    const Vector3x8 to_eye = (Vector3x8::broadcast(eye_W) - p).normalized();
    Vec8f diffuse = kEven + kFromAbove * normal.z, gloss = broadcast(0.0F);
    for (std::size_t k = 0; k < lamps.size(); ++k) {
      const Vec8f share = load(&visible[k][i]);
      if (!any(share > 0)) continue;
      const Lamp& lamp = lamps[k].lamp();
      const Vector3x8 to_lamp = Vector3x8::broadcast(lamp.p_W.cast<float>()) - p;
      const Vec8f square = to_lamp.dot(to_lamp);
      const Vector3x8 l = to_lamp * (1 / sqrt(square));
      const Vec8f slope = max(normal.dot(l), broadcast(0.0F));
      const auto full = static_cast<float>(lamp.brightness * lamp.distance_m * lamp.distance_m);
      const Vec8f light = slope > 0 ? full * share / square : broadcast(0.0F);
      diffuse += light * slope;
      gloss += light * sharpen(max(normal.dot((l + to_eye).normalized()), broadcast(0.0F)));
    }
    const Vec8f share = load(&surface.gloss[i]);
    const Mask8 shown = share >= 0;
    const Vec8f shine = 8 * share * gloss, nothing = broadcast(kBackground);
    const Vec8f red = shown ? diffuse * load(&surface.red[i]) + shine : nothing;
    const Vec8f green = shown ? diffuse * load(&surface.green[i]) + shine : nothing;
    const Vec8f blue = shown ? diffuse * load(&surface.blue[i]) + shine : nothing;
    for (int lane = 0; lane < kLanes; ++lane) {
      float* const to = rgb + 3 * (i + lane);
      to[0] = red[lane];
      to[1] = green[lane];
      to[2] = blue[lane];
    }
  }
}

}  // namespace

void find_surface(const View& view, std::size_t tile, TileSurface& out) {
  const std::size_t first = tile * TileGrid::kPixels;
  TileValues x, y;
  view.raster.rays().copy_tile(tile, x.data(), y.data());
  find_pixels(view, view.raster.owner().data() + first, view.raster.inverse_depth().data() + first,
              x, y, out);
}

void shade_tile(const TileSurface& surface, const Eigen::Vector3f& eye_W,
                const std::vector<ShadowMap>& lamps, float* rgb, ShadowMap::Range* lit_from) {
  std::array<TileValues, kMaxLamps> visible;
  for (std::size_t i = 0; i < lamps.size(); ++i) {
    lit_from[i] = lamps[i].light(surface.points, visible[i]);
  }
  shade_pixels(surface, eye_W, lamps, visible, rgb);
}

}  // namespace aprsim::render
