#include "world/render/renderer.hpp"

#include <algorithm>
#include <array>

#include "world/render/raster/parallel.hpp"

namespace aprsim::render {
namespace {

/// Points that the camera may see: where its rays at the edge and in the middle meet the floor, or
/// 5 m away.
std::vector<Eigen::Vector3d> seen_by(const scene::Camera& camera) {
  constexpr double kFar_m = 5;
  const Eigen::Isometry3d X_WC = camera.X_PC.isometry();
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i <= 4; ++i) {
    for (int k = 0; k <= 4; ++k) {
      const auto direction = camera.lens.direction(
          {0.25 * i * (camera.lens.width_px - 1), 0.25 * k * (camera.lens.height_px - 1)});
      if (!direction) continue;
      const Eigen::Vector3d ray =
          X_WC.linear() * Eigen::Vector3d(direction->x(), direction->y(), 1);
      const double to_floor =
          ray.z() < 0 ? std::max(0.0, X_WC.translation().z()) / -ray.z() : kFar_m;
      points.emplace_back(X_WC.translation() + std::min(kFar_m, to_floor) * ray);
    }
  }
  if (points.empty()) points.push_back(X_WC.translation());
  return points;
}

/// Corners of a box with a margin.
std::vector<Eigen::Vector3d> corners(const Eigen::AlignedBox3d& box) {
  constexpr double kMargin_m = 0.3;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d side(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    points.emplace_back(box.center() + side.cwiseProduct(0.5 * box.sizes()) + kMargin_m * side);
  }
  return points;
}

}  // namespace

std::vector<Lamp> lamps_over(const Eigen::AlignedBox3d& extent) {
  constexpr double kAbove_m = 2.3, kAside_m = 0.8;
  const Eigen::AlignedBox3d box =
      extent.isEmpty() ? Eigen::AlignedBox3d(Eigen::Vector3d::Zero()) : extent;
  Eigen::Vector3d middle = box.center();
  middle.z() = box.max().z() + kAbove_m;
  return {{.p_W = middle + Eigen::Vector3d(-kAside_m, -0.5 * kAside_m, 0),
           .radius_m = 0.08,
           .brightness = 0.42F,
           .distance_m = kAbove_m},
          {.p_W = middle + Eigen::Vector3d(kAside_m, 0.7 * kAside_m, 0),
           .radius_m = 0.08,
           .brightness = 0.30F,
           .distance_m = kAbove_m}};
}

Renderer::Renderer(const scene::Camera& camera, const std::vector<Lamp>& lamps, std::uint64_t seed,
                   const Eigen::AlignedBox3d& cell)
    : camera_(camera),
      X_WC_(camera.X_PC.isometry()),
      X_CW_(X_WC_.inverse()),
      raster_(camera.lens, Rasterizer::Contents::kDepthAndOwner, budget_),
      R_WC_(X_WC_.linear().cast<float>()),
      eye_W_(X_WC_.translation().cast<float>()),
      light_(camera.lens.width_px, camera.lens.height_px, 3),
      exposure_(camera, seed),
      rgb_(camera.lens.width_px, camera.lens.height_px, 3) {
  const std::vector<Eigen::Vector3d> lit =
      camera.is_fixed() || cell.isEmpty() ? seen_by(camera) : corners(cell);
  shadows_.reserve(kMaxLamps);
  for (const Lamp& lamp : lamps) {
    if (shadows_.size() < kMaxLamps) shadows_.emplace_back(lamp, lit, budget_);
  }
  lit_from_.resize(grid().tiles() * shadows_.size());
  // It is there, whatever the limit.
  (void)budget_.take(fixed_bytes(camera));
}

std::uint64_t Renderer::fixed_bytes(const scene::Camera& camera) {
  constexpr std::uint64_t kLamps = 2;
  const TileGrid grid(camera.lens.width_px, camera.lens.height_px);
  // Light, colours and dirt.
  constexpr std::uint64_t kPixel = 3 * sizeof(float) + 3 + 1;
  return Rasterizer::fixed_bytes(camera.lens, Rasterizer::Contents::kDepthAndOwner) +
         grid.pixels() * kPixel + grid.tiles() * kLamps * sizeof(ShadowMap::Range) +
         kLamps * ShadowMap::fixed_bytes();
}

bool Renderer::set_camera(const scene::Camera& camera, const Eigen::Isometry3d& X_WC,
                          double time_s) {
  const bool changed = exposure_.set_flaws(camera, time_s);
  all_due_ = all_due_ || changed;
  if (X_WC.matrix() == X_WC_.matrix()) return changed;
  X_WC_ = X_WC;
  X_CW_ = X_WC.inverse();
  R_WC_ = X_WC.linear().cast<float>();
  eye_W_ = X_WC.translation().cast<float>();
  return true;
}

/// False where the limit of memory would be exceeded.
bool Renderer::remember(const std::vector<Placement>& placements) {
  if (!budget_.make_room(placements_, placements.size()) ||
      !budget_.make_room(R_WP_, placements.size())) {
    return false;
  }
  for (const Placement& placement : placements) {
    placements_.push_back(placement);
    R_WP_.emplace_back(placement.X_W.linear().cast<float>());
  }
  return true;
}

Result<std::size_t> Renderer::draw(const std::vector<Placement>& placements, std::uint64_t frame,
                                   int threads) {
  TileSet drawn;
  if (remember(placements)) drawn = raster_.draw(placements, X_CW_, threads);
  for (ShadowMap& shadow : shadows_) {
    if (!budget_.exceeded()) shadow.draw(placements, threads);
  }
  if (budget_.exceeded()) {
    return fail(ErrorCode::kFailedPrecondition, "memory",
                camera_.name + " sees more than its limit of memory permits");
  }
  const TileSet shaded = tiles_to_shade(drawn);
  std::vector<std::size_t> tiles;
  for (std::size_t tile = 0; tile < shaded.size(); ++tile) {
    if (shaded[tile] != 0) tiles.push_back(tile);
  }
  for_each_parallel(tiles.size(), threads, [&](std::size_t i) { shade_tile(tiles[i]); });
  expose(shaded, frame, threads);
  return tiles.size();
}

TileSet Renderer::tiles_to_shade(const TileSet& drawn) const {
  TileSet out = drawn;
  if (!exposed_) std::fill(out.begin(), out.end(), std::uint8_t{1});
  for (std::size_t tile = 0; tile < out.size(); ++tile) {
    for (std::size_t i = 0; i < shadows_.size() && out[tile] == 0; ++i) {
      if (shadows_[i].changed(lit_from_[tile * shadows_.size() + i])) out[tile] = 1;
    }
  }
  return out;
}

View Renderer::view() const {
  return {.raster = raster_,
          .placements = placements_,
          .R_WP = R_WP_,
          .R_WC = R_WC_,
          .eye_W = eye_W_,
          .pixel = camera_.lens.focal_px.cwiseInverse().cast<float>()};
}

std::pair<int, int> Renderer::corner_of(std::size_t tile) const {
  return {static_cast<int>(tile) % grid().columns * TileGrid::kWidth,
          static_cast<int>(tile) / grid().columns * TileGrid::kHeight};
}

void Renderer::shade_tile(std::size_t tile) {
  TileSurface surface;
  find_surface(view(), tile, surface);
  std::array<float, 3 * TileGrid::kPixels> rgb;
  render::shade_tile(surface, eye_W_, shadows_, rgb.data(),
                     lit_from_.data() + tile * shadows_.size());
  const auto [x0, y0] = corner_of(tile);
  const int width = std::min(TileGrid::kWidth, grid().width - x0);
  for (int row = 0; row < std::min(TileGrid::kHeight, grid().height - y0); ++row) {
    std::copy_n(rgb.data() + 3 * TileGrid::kWidth * row, 3 * width, light_.at(x0, y0 + row));
  }
}

void Renderer::expose(const TileSet& shaded, std::uint64_t frame, int threads) {
  const bool everything = !exposed_ || all_due_ || (exposure_.is_noisy() && frame != frame_);
  exposed_ = true;
  all_due_ = false;
  frame_ = frame;
  // Light reaches the neighbouring tiles: no kernel is wider than a tile.
  std::vector<std::size_t> tiles;
  const int beyond = exposure_.reach_px() > 0 ? 1 : 0;
  for (int row = 0; row < grid().rows; ++row) {
    for (int column = 0; column < grid().columns; ++column) {
      bool due = everything;
      for (int r = std::max(0, row - beyond); r <= std::min(grid().rows - 1, row + beyond); ++r) {
        for (int c = std::max(0, column - beyond);
             c <= std::min(grid().columns - 1, column + beyond); ++c) {
          due |= shaded[grid().tile_at(c, r)] != 0;
        }
      }
      if (due) tiles.push_back(grid().tile_at(column, row));
    }
  }
  for_each_parallel(tiles.size(), threads, [&](std::size_t i) {
    const int tile = static_cast<int>(tiles[i]);
    exposure_.expose(light_, tile % grid().columns, tile / grid().columns, frame, rgb_);
  });
}

Picture<float> Renderer::depth() const {
  Picture<float> out(grid().width, grid().height, 1);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const float inverse = raster_.inverse_depth()[grid().index(x, y)];
      *out.at(x, y) = inverse > 0 ? 1 / inverse : 0;
    }
  }
  return out;
}

Picture<std::uint16_t> Renderer::segments(const std::vector<std::uint16_t>& object_of) const {
  Picture<std::uint16_t> out(grid().width, grid().height, 1);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const std::uint32_t owner = raster_.owner()[grid().index(x, y)];
      if (owner != Rasterizer::kNothing) {
        *out.at(x, y) = object_of.at(owner >> Rasterizer::kFacetBits);
      }
    }
  }
  return out;
}

Picture<float> Renderer::normals() const {
  Picture<float> out(grid().width, grid().height, 3);
  TileSurface surface;
  const View seen = view();
  for (std::size_t tile = 0; tile < grid().tiles(); ++tile) {
    find_surface(seen, tile, surface);
    const TilePoints& points = surface.points;
    const auto [x0, y0] = corner_of(tile);
    for (int i = 0; i < TileGrid::kPixels; ++i) {
      const int x = x0 + i % TileGrid::kWidth, y = y0 + i / TileGrid::kWidth;
      if (x >= out.width || y >= out.height) continue;
      const auto k = static_cast<std::size_t>(i);
      if (raster_.owner()[tile * TileGrid::kPixels + k] == Rasterizer::kNothing) continue;
      const float normal[] = {points.normal_x[k], points.normal_y[k], points.normal_z[k]};
      std::copy_n(normal, 3, out.at(x, y));
    }
  }
  return out;
}

}  // namespace aprsim::render
