#include "world/render/raster/rasterizer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "world/base/simd/vec8f.hpp"
#include "world/base/simd/vector_clones.hpp"
#include "world/render/raster/parallel.hpp"

namespace aprsim::render {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr double kNear_m = 1e-3;

inline Vec8f plane(const Eigen::Vector3f& p, const Vec8f& x, const Vec8f& y) {
  return p.x() * x + p.y() * y + p.z();
}

struct TileRays {
  const float *x, *y;
  const Rays::Bounds* rows;
};

/// Draws one facet into one tile.
APRSIM_VECTOR_CLONES void draw_facet(const Rasterizer::Facet& facet, std::uint32_t owner,
                                     const TileRays& rays, float* depths, std::uint32_t* owners) {
  for (int row = 0; row < TileGrid::kHeight; ++row) {
    const Rays::Bounds& bounds = rays.rows[row];
    if (facet.y_max < bounds.y_min || facet.y_min > bounds.y_max) continue;
    for (int i = row * TileGrid::kWidth; i < (row + 1) * TileGrid::kWidth; i += kLanes) {
      const Vec8f x = load(rays.x + i);
      if (!any((x >= facet.x_min) & (x <= facet.x_max))) continue;
      const Vec8f y = load(rays.y + i);
      const Vec8f a = plane(facet.edge[0], x, y), b = plane(facet.edge[1], x, y),
                  c = plane(facet.edge[2], x, y), w = plane(facet.inverse, x, y);
      const Vec8f before = load(depths + i);
      const Mask8 seen = (a >= 0) & (b >= 0) & (c >= 0) & (w > before);
      if (!any(seen)) continue;
      const Vec8f after = seen ? w : before;
      std::memcpy(depths + i, &after, sizeof after);
      Vec8u who;
      std::memcpy(&who, owners + i, sizeof who);
      const Vec8u mine = Vec8u{} + owner;
      who = seen ? mine : who;
      std::memcpy(owners + i, &who, sizeof who);
    }
  }
}

/// Whether a plane's inner side may meet the tile.
bool may_meet(const Eigen::Vector3f& plane, const Rays::Bounds& tile) {
  return std::max(plane.x() * tile.x_min, plane.x() * tile.x_max) +
             std::max(plane.y() * tile.y_min, plane.y() * tile.y_max) + plane.z() >=
         0;
}

/// False where the camera sees nothing of it: its back, or it is behind.
bool make_facet(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                Rasterizer::Facet& out) {
  if (a.z() < kNear_m && b.z() < kNear_m && c.z() < kNear_m) return false;
  const Eigen::Vector3d n = (b - a).cross(c - a);
  const double distance = n.dot(a);
  if (!(distance < 0)) return false;
  // The planes of an edge have opposite bits in its two triangles: no gap between them.
  out.edge[0] = c.cross(b).cast<float>();
  out.edge[1] = a.cross(c).cast<float>();
  out.edge[2] = b.cross(a).cast<float>();
  out.inverse = (n / distance).cast<float>();
  if (a.z() < kNear_m || b.z() < kNear_m || c.z() < kNear_m) {
    out.x_min = out.y_min = -kInfinity;
    out.x_max = out.y_max = kInfinity;
    return true;
  }
  constexpr float kMargin = 1e-6F;  // over rounding
  const Eigen::Vector3d x(a.x() / a.z(), b.x() / b.z(), c.x() / c.z());
  const Eigen::Vector3d y(a.y() / a.z(), b.y() / b.z(), c.y() / c.z());
  out.x_min = static_cast<float>(x.minCoeff()) - kMargin;
  out.x_max = static_cast<float>(x.maxCoeff()) + kMargin;
  out.y_min = static_cast<float>(y.minCoeff()) - kMargin;
  out.y_max = static_cast<float>(y.maxCoeff()) + kMargin;
  return true;
}

/// Columns or rows of tiles whose directions overlap [low, high]: [first, second).
std::pair<int, int> overlap(const std::vector<float>& mins, const std::vector<float>& maxs,
                            float low, float high) {
  int first = 0, last = static_cast<int>(mins.size());
  while (first < last && maxs[static_cast<std::size_t>(first)] < low) ++first;
  while (last > first && mins[static_cast<std::size_t>(last) - 1] > high) --last;
  return {first, last};
}

/// Whether a facet may be seen within the tile.
bool meets(const Rasterizer::Facet& facet, const Rays::Bounds& tile) {
  return facet.x_max >= tile.x_min && facet.x_min <= tile.x_max && facet.y_max >= tile.y_min &&
         facet.y_min <= tile.y_max && may_meet(facet.edge[0], tile) &&
         may_meet(facet.edge[1], tile) && may_meet(facet.edge[2], tile);
}

}  // namespace

Rasterizer::Rasterizer(const scene::Lens& lens, Contents contents, MemoryBudget& budget)
    : budget_(budget),
      rays_(lens),
      inverse_depth_(rays_.grid.pixels()),
      owner_(contents == Contents::kDepth ? 0 : rays_.grid.pixels(), kNothing),
      changed_(rays_.grid.tiles()) {}

std::uint64_t Rasterizer::fixed_bytes(const scene::Lens& lens, Contents contents) {
  const TileGrid grid(lens.width_px, lens.height_px);
  // Each tile has its mark of changes, and three numbers while drawing.
  constexpr std::uint64_t kTile = sizeof(std::uint8_t) + 3 * sizeof(std::size_t);
  return Rays::bytes(lens) + grid.tiles() * kTile +
         grid.pixels() *
             (sizeof(float) + (contents == Contents::kDepth ? 0 : sizeof(std::uint32_t)));
}

bool Rasterizer::place(Placed& placed, const Placement& at, const Eigen::Isometry3d& X_CW) {
  placed.at = at;
  placed.drawn = true;
  const Eigen::Isometry3d X = X_CW * at.X_W;
  const auto& triangles = at.mesh->triangles;
  if (!budget_.make_room(placed.facets, triangles.size())) return false;
  Facet facet;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto& p = triangles[i].points;
    if (!make_facet(X * p[0].cast<double>(), X * p[1].cast<double>(), X * p[2].cast<double>(),
                    facet)) {
      continue;
    }
    facet.triangle = static_cast<std::uint32_t>(i);
    placed.facets.push_back(facet);
  }
  return sort_into_tiles(placed);
}

bool Rasterizer::add_meeting(std::size_t tile, std::size_t facet) {
  if (meetings_.size() == meetings_.capacity()) {
    constexpr std::size_t kLeast = 1024;
    // While it grows, both lists are there.
    const std::size_t before = meetings_.capacity(), after = std::max(kLeast, 2 * before);
    if (!budget_.take(after * sizeof(meetings_[0]))) return false;
    meetings_.reserve(after);
    budget_.give(before * sizeof(meetings_[0]));
  }
  meetings_.emplace_back(static_cast<std::uint32_t>(tile), static_cast<std::uint32_t>(facet));
  return true;
}

bool Rasterizer::sort_into_tiles(Placed& placed) {
  const TileGrid& grid = rays_.grid;
  std::vector<std::uint32_t>& begin = placed.begin;
  if (!budget_.make_room(begin, grid.tiles() + 1)) return false;
  if (!budget_.make_room(placed.tiles, grid.tiles())) return false;
  begin.assign(grid.tiles() + 1, 0);
  meetings_.clear();
  for (std::size_t i = 0; i < placed.facets.size(); ++i) {
    const Facet& facet = placed.facets[i];
    const auto [c0, c1] = overlap(rays_.column_min, rays_.column_max, facet.x_min, facet.x_max);
    const auto [r0, r1] = overlap(rays_.row_min, rays_.row_max, facet.y_min, facet.y_max);
    for (int row = r0; row < r1; ++row) {
      for (int column = c0; column < c1; ++column) {
        const std::size_t tile = grid.tile_at(column, row);
        if (!meets(facet, rays_.tiles[tile])) continue;
        if (!add_meeting(tile, i)) return false;
        ++begin[tile + 1];
      }
    }
  }
  placed.tiles.assign(grid.tiles(), 0);
  for (std::size_t tile = 0; tile < grid.tiles(); ++tile) {
    placed.tiles[tile] = begin[tile + 1] > 0 ? 1 : 0;
    begin[tile + 1] += begin[tile];
  }
  // With a margin, since what moves soon meets a few tiles more.
  if (placed.facet_of_tile.capacity() < meetings_.size() &&
      !budget_.make_room(placed.facet_of_tile, meetings_.size() + meetings_.size() / 4)) {
    return false;
  }
  placed.facet_of_tile.resize(meetings_.size());
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (const auto& [tile, facet] : meetings_) placed.facet_of_tile[next[tile]++] = facet;
  return true;
}

const TileSet& Rasterizer::draw(const std::vector<Placement>& placements,
                                const Eigen::Isometry3d& X_CW, int threads) {
  const bool moved = !placed_.empty() && X_CW.matrix() != X_CW_.matrix();
  X_CW_ = X_CW;
  std::fill(changed_.begin(), changed_.end(), std::uint8_t{moved});
  if (placements.size() > placed_.size() &&
      !budget_.take((placements.size() - placed_.size()) * sizeof(Placed))) {
    return changed_;
  }
  placed_.resize(placements.size());
  for (std::size_t i = 0; i < placements.size(); ++i) {
    Placed& placed = placed_[i];
    if (placed.drawn && !moved && placed.at.same(placements[i])) continue;
    if (placed.drawn) unite(changed_, placed.tiles);
    if (!place(placed, placements[i], X_CW)) return changed_;
    unite(changed_, placed.tiles);
  }
  std::vector<std::size_t> tiles;
  for (std::size_t tile = 0; tile < changed_.size(); ++tile) {
    if (changed_[tile] != 0) tiles.push_back(tile);
  }
  for_each_parallel(tiles.size(), threads, [&](std::size_t i) { draw_tile(tiles[i]); });
  return changed_;
}

void Rasterizer::draw_tile(std::size_t tile) {
  const std::size_t first = tile * TileGrid::kPixels;
  float* const depths = inverse_depth_.data() + first;
  std::array<std::uint32_t, TileGrid::kPixels> unused;
  std::uint32_t* const owners = owner_.empty() ? unused.data() : owner_.data() + first;
  std::fill_n(depths, TileGrid::kPixels, 0.0F);
  std::fill_n(owners, TileGrid::kPixels, kNothing);
  std::array<float, TileGrid::kPixels> x, y;
  rays_.copy_tile(tile, x.data(), y.data());
  const TileRays rays{x.data(), y.data(), rays_.rows.data() + tile * TileGrid::kHeight};
  for (std::size_t k = 0; k < placed_.size(); ++k) {
    const Placed& placed = placed_[k];
    for (std::uint32_t i = placed.begin[tile]; i < placed.begin[tile + 1]; ++i) {
      const std::uint32_t facet = placed.facet_of_tile[i];
      draw_facet(placed.facets[facet], static_cast<std::uint32_t>(k) << kFacetBits | facet, rays,
                 depths, owners);
    }
  }
}

}  // namespace aprsim::render
