#include "world/render/raster/shadow_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "world/base/simd/vec8f.hpp"
#include "world/base/simd/vector_clones.hpp"

namespace aprsim::render {
namespace {

constexpr int kSize = 1536;  // pixels along each side
constexpr int kTaps = 16, kPatterns = 16;
constexpr float kNearSearch_px = 4, kFarSearch_px = 20, kMaxPenumbra_px = 24;
constexpr float kBias = 4e-4F;  // share of the depth
constexpr float kNormalOffset_px = 1.5F;
constexpr float kMostSlope = 0.02F;  // share of the inverse depth a pixel
constexpr float kRounding_px = 0.5F;
constexpr double kMargin = 1.03;
constexpr int kBlock = DepthBounds::kBlock_px;
static_assert(DepthBounds::kReach_px >= kMaxPenumbra_px &&
              DepthBounds::kReach_px >= kFarSearch_px && kSize % (kBlock * kLanes) == 0);
static_assert(TileGrid::kWidth == 32 && TileGrid::kHeight == 16);

/// Samples of eight pixels side by side: patterns repeat after four, in rows and columns.
struct Taps {
  Vec8f u[kTaps], v[kTaps];
};

/// Points spread evenly over the unit disc (Vogel 1979), in several turns.
std::array<Taps, 4> make_taps() {
  std::array<Taps, 4> taps;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int pattern = 0; pattern < kPatterns; ++pattern) {
    Taps& row = taps[static_cast<std::size_t>(pattern / 4)];
    for (int i = 0; i < kTaps; ++i) {
      const double r = std::sqrt((i + 0.5) / kTaps);
      // Neighbours differ by much: 7 has no factor in common with 16.
      const double angle = golden * i + 2 * std::numbers::pi * ((7 * pattern) % kPatterns) / 16.0;
      for (const int lane : {pattern % 4, pattern % 4 + 4}) {
        row.u[i][lane] = static_cast<float>(r * std::cos(angle));
        row.v[i][lane] = static_cast<float>(r * std::sin(angle));
      }
    }
  }
  return taps;
}

/// For the row of a tile.
const Taps& taps(int row) {
  static const std::array<Taps, 4> all = make_taps();
  return all[static_cast<std::size_t>(row % 4)];
}

/// The lamp as a camera that looks at the middle of what it lights.
Eigen::Isometry3d look_at(const Eigen::Vector3d& from, const Eigen::Vector3d& at) {
  const Eigen::Vector3d z = (at - from).normalized();
  const Eigen::Vector3d x = z.unitOrthogonal();
  Eigen::Isometry3d X_WL = Eigen::Isometry3d::Identity();
  X_WL.linear() << x, z.cross(x), z;
  X_WL.translation() = from;
  return X_WL.inverse();
}

Eigen::Vector3d middle(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

double focal_of(const Eigen::Isometry3d& X_LW, const std::vector<Eigen::Vector3d>& lit) {
  double extent = 0.05;
  for (const auto& p_W : lit) {
    const Eigen::Vector3d p = X_LW * p_W;
    if (p.z() > 0.1) extent = std::max(extent, p.head<2>().cwiseAbs().maxCoeff() / p.z());
  }
  return 0.5 * kSize / (kMargin * extent);
}

scene::Lens lens_of(double focal) {
  scene::Lens lens;
  lens.width_px = lens.height_px = kSize;
  lens.focal_px = {focal, focal};
  lens.centre_px = Eigen::Vector2d::Constant(0.5 * (kSize - 1));
  return lens;
}

/// The map as the loops over pixels see it.
struct Map {
  const float* depths;
  const DepthBounds::Block* blocks;
  Eigen::Matrix3f R_LW;
  Eigen::Vector3f p_L;  // of the world's origin
  float focal, lamp_radius_m;
};

/// Eight surface points as the lamp sees them: where in the map, and the inverse depths that their
/// planes have there, with the bias. Lanes that are not `seen` have some numbers.
struct Receivers {
  Mask8 seen, lit_alone;
  Vec8f u, v, z, limit, per_u, per_v;
};

/// Least and greatest place in the map by lane.
struct Spread {
  Vec8f u_min = broadcast(1e9F), u_max = broadcast(-1e9F);
  Vec8f v_min = broadcast(1e9F), v_max = broadcast(-1e9F);
};

inline Receivers receive(const Map& map, const Vector3x8& p_W, const Vector3x8& normal_W) {
  const Vector3x8 normal = map.R_LW * normal_W;
  const Vector3x8 at = map.R_LW * p_W + Vector3x8::broadcast(map.p_L);
  const Mask8 faces = normal.dot(at) < 0;
  const Vector3x8 p = at + normal * (at.z * (kNormalOffset_px / map.focal));
  const Mask8 before = p.z > 0;
  Receivers out;
  out.z = before ? p.z : broadcast(1.0F);
  const Vec8f w = 1 / out.z;
  constexpr float kCentre = 0.5F * (kSize - 1);
  out.u = map.focal * (p.x * w) + kCentre;
  out.v = map.focal * (p.y * w) + kCentre;
  const Mask8 inside = before & (out.u >= 0) & (out.v >= 0) & (out.u < kSize) & (out.v < kSize);
  out.seen = faces & inside;
  out.lit_alone = faces & ~inside;
  out.u = inside ? out.u : broadcast(0.0F);
  out.v = inside ? out.v : broadcast(0.0F);
  out.limit = (1 + kBias) * w;
  // A plane n p = d has the inverse depth n (x, y, 1) / d in the direction (x, y, 1).
  const Vec8f facing = normal.dot(p) * map.focal;
  const Vec8f scale = facing < 0 ? 1 / facing : broadcast(0.0F), most = kMostSlope * w;
  out.per_u = max(-most, min(most, normal.x * scale));
  out.per_v = max(-most, min(most, normal.y * scale));
  return out;
}

inline void include(Spread& spread, const Receivers& at) {
  const Vec8f far = broadcast(1e9F);
  spread.u_min = min(spread.u_min, at.seen ? at.u : far);
  spread.v_min = min(spread.v_min, at.seen ? at.v : far);
  spread.u_max = max(spread.u_max, at.seen ? at.u : -far);
  spread.v_max = max(spread.v_max, at.seen ? at.v : -far);
}

/// Blocks by lane.
struct Blocks {
  Vec8f middle, per_u, per_v, near_low, near_high, low, high;
};

inline Blocks blocks_at(const Map& map, const Vec8i& places) {
  const DepthBounds::Block& first = map.blocks[places[0]];
  Blocks out{broadcast(first.middle),   broadcast(first.per_u),     broadcast(first.per_v),
             broadcast(first.near_low), broadcast(first.near_high), broadcast(first.low),
             broadcast(first.high)};
  if (!any(places != places[0])) return out;
  for (int lane = 1; lane < kLanes; ++lane) {
    const DepthBounds::Block& block = map.blocks[places[lane]];
    out.middle[lane] = block.middle;
    out.per_u[lane] = block.per_u;
    out.per_v[lane] = block.per_v;
    out.near_low[lane] = block.near_low;
    out.near_high[lane] = block.near_high;
    out.low[lane] = block.low;
    out.high[lane] = block.high;
  }
  return out;
}

/// The bounds of the blocks that points are in, by lane, about the planes of the points: what is
/// within reach is nearer than they are by `low` to `high`.
struct Bounds {
  Vec8f near_low, near_high, low, high;
  Vec8f nearest;  // inverse depth
};

inline Bounds bounds_at(const Map& map, const Receivers& at) {
  const Vec8i column = clamp(truncate(at.u + kRounding_px), 0, kSize - 1) / kBlock;
  const Vec8i row = clamp(truncate(at.v + kRounding_px), 0, kSize - 1) / kBlock;
  const Blocks block = blocks_at(map, row * (kSize / kBlock) + column);
  constexpr float kHalf = 0.5F * (kBlock - 1);
  const Vec8f plane = block.middle + block.per_u * (at.u - to_float(column * kBlock) - kHalf) +
                      block.per_v * (at.v - to_float(row * kBlock) - kHalf);
  const Vec8f above = plane - at.limit;
  const Vec8f tilt = abs(block.per_u - at.per_u) + abs(block.per_v - at.per_v);
  constexpr float kNear_px = DepthBounds::kNear_px + kRounding_px;
  constexpr float kWide_px = DepthBounds::kReach_px + kRounding_px;
  return {above + block.near_low - kNear_px * tilt, above + block.near_high + kNear_px * tilt,
          above + block.low - kWide_px * tilt, above + block.high + kWide_px * tilt,
          plane + block.high + kWide_px * (abs(block.per_u) + abs(block.per_v))};
}

/// Radius of the penumbra that something at an inverse depth casts.
inline Vec8f penumbra_px(const Map& map, const Receivers& at, const Vec8f& blocker) {
  const Vec8f depth_m = 1 / blocker;
  const Vec8f width_m = map.lamp_radius_m * (at.z - depth_m) / max(depth_m, broadcast(0.01F));
  return clamp(map.focal * width_m / at.z, 0.7F, kMaxPenumbra_px);
}

/// The inverse depths at places beside points, and whether those are nearer than the points.
struct Sample {
  Vec8f depth;
  Mask8 blocks;
};

inline Sample sample(const Map& map, const Receivers& at, const Vec8f& du, const Vec8f& dv) {
  const Vec8i x = clamp(truncate(at.u + du + kRounding_px), 0, kSize - 1);
  const Vec8i y = clamp(truncate(at.v + dv + kRounding_px), 0, kSize - 1);
  constexpr int kColumns = kSize / TileGrid::kWidth;
  const Vec8i tile = (y >> 4) * kColumns + (x >> 5);
  const Vec8i place = (tile << 9) + ((y & 15) << 5) + (x & 31);
  Sample out;
  for (int lane = 0; lane < kLanes; ++lane) out.depth[lane] = map.depths[place[lane]];
  out.blocks =
      out.depth > at.limit + at.per_u * (to_float(x) - at.u) + at.per_v * (to_float(y) - at.v);
  return out;
}

/// Samples that are nearer to the lamp than points: their number and the sum of their inverse
/// depths.
struct Blockers {
  Vec8i count = broadcast(0);
  Vec8f sum = broadcast(0.0F);
};

/// Every second sample from `first` on.
inline void search(const Map& map, const Receivers& at, const Taps& taps, int first,
                   float radius_px, Blockers& out) {
  for (int i = first; i < kTaps; i += 2) {
    const Sample here = sample(map, at, radius_px * taps.u[i], radius_px * taps.v[i]);
    out.sum += here.blocks ? here.depth : broadcast(0.0F);
    out.count -= here.blocks;
  }
}

/// Share of samples within the penumbras that are lit.
inline Vec8f lit_share(const Map& map, const Receivers& at, const Taps& taps,
                       const Vec8f& width_px) {
  Vec8i dark = broadcast(0);
  for (int i = 0; i < kTaps; ++i) {
    dark -= sample(map, at, width_px * taps.u[i], width_px * taps.v[i]).blocks;
  }
  return 1 - to_float(dark) * (1.0F / kTaps);
}

/// Share of the lamp, by samples of the map, for the lanes that are `open`. `widest_px`: bound of
/// the penumbra.
inline Vec8f soft_light(const Map& map, const Receivers& at, const Taps& taps, const Mask8& open,
                        const Vec8f& widest_px) {
  Blockers blockers;
  search(map, at, taps, 0, kNearSearch_px, blockers);
  // The near samples alone decide narrow penumbras, unless an edge is among them.
  const Mask8 narrow = widest_px <= broadcast(kNearSearch_px);
  const Mask8 even = (blockers.count == 0) | (blockers.count == kTaps / 2);
  Vec8f light = blockers.count == 0 ? broadcast(1.0F) : broadcast(0.0F);
  Mask8 rest = open & ~(narrow & even);
  if (!any(rest)) return light;
  Blockers all = blockers;
  search(map, at, taps, 1, kFarSearch_px, all);
  const Vec8i count = narrow ? blockers.count : all.count;
  const Vec8f sum = narrow ? blockers.sum : all.sum;
  const Vec8f mean = count > 0 ? sum / to_float(count) : 1 / at.z;
  const Vec8f width_px = penumbra_px(map, at, mean);
  light = rest & (count == 0) ? broadcast(1.0F) : light;
  light = rest & (count == kTaps) ? broadcast(0.0F) : light;
  rest &= (count > 0) & ((count < kTaps) | (width_px > broadcast(kFarSearch_px)));
  return any(rest) ? (rest ? lit_share(map, at, taps, width_px) : light) : light;
}

/// Most points are decided by the bounds of their block, without a sample.
inline Vec8f light_of(const Map& map, const Receivers& at, const Taps& taps) {
  const Bounds bounds = bounds_at(map, at);
  // No sample is farther away than the widest penumbra that anything there may cast.
  const Vec8f widest_px = penumbra_px(map, at, max(bounds.nearest, 1 / at.z));
  const Mask8 narrow = widest_px <= broadcast(DepthBounds::kNear_px - kRounding_px);
  const Mask8 lit = (bounds.high <= 0) | (narrow & (bounds.near_high <= 0));
  const Mask8 dark = (bounds.low > 0) | (narrow & (bounds.near_low > 0));
  const Vec8f decided = dark ? broadcast(0.0F) : broadcast(1.0F);
  const Mask8 open = at.seen & ~lit & ~dark;
  return any(open) ? (open ? soft_light(map, at, taps, open, widest_px) : decided) : decided;
}

APRSIM_VECTOR_CLONES Spread light_pixels(const Map& map, const TilePoints& points,
                                         TileValues& visible) {
  Spread spread;
  for (int i = 0; i < TileGrid::kPixels; i += kLanes) {
    const Receivers at =
        receive(map, {load(&points.x[i]), load(&points.y[i]), load(&points.z[i])},
                {load(&points.normal_x[i]), load(&points.normal_y[i]), load(&points.normal_z[i])});
    Vec8f light = at.lit_alone ? broadcast(1.0F) : broadcast(0.0F);
    if (any(at.seen)) {
      include(spread, at);
      light = at.seen ? light_of(map, at, taps(i / TileGrid::kWidth)) : light;
    }
    store(&visible[i], light);
  }
  return spread;
}

/// The tiles of the map around these places.
ShadowMap::Range range_of(const Spread& spread, const TileGrid& grid) {
  float u_min = 1e9F, u_max = -1e9F, v_min = 1e9F, v_max = -1e9F;
  for (int lane = 0; lane < kLanes; ++lane) {
    u_min = std::min(u_min, spread.u_min[lane]);
    u_max = std::max(u_max, spread.u_max[lane]);
    v_min = std::min(v_min, spread.v_min[lane]);
    v_max = std::max(v_max, spread.v_max[lane]);
  }
  if (u_min > u_max) return {};
  constexpr float kMost_px = DepthBounds::kReach_px + kBlock;
  const auto tile = [](float at, int size, int count) {
    return std::clamp(static_cast<int>(std::floor(at / static_cast<float>(size))), 0, count - 1);
  };
  return {tile(u_min - kMost_px, TileGrid::kWidth, grid.columns),
          tile(u_max + kMost_px, TileGrid::kWidth, grid.columns),
          tile(v_min - kMost_px, TileGrid::kHeight, grid.rows),
          tile(v_max + kMost_px, TileGrid::kHeight, grid.rows)};
}

}  // namespace

std::uint64_t ShadowMap::fixed_bytes() {
  return Rasterizer::fixed_bytes(lens_of(1), Rasterizer::Contents::kDepth) +
         DepthBounds::bytes(kSize);
}

ShadowMap::ShadowMap(const Lamp& lamp, const std::vector<Eigen::Vector3d>& lit,
                     MemoryBudget& budget)
    : lamp_(lamp),
      X_LW_(look_at(lamp.p_W, middle(lit))),
      focal_(static_cast<float>(focal_of(X_LW_, lit))),
      rasterizer_(lens_of(focal_of(X_LW_, lit)), Rasterizer::Contents::kDepth, budget),
      bounds_(kSize) {}

void ShadowMap::draw(const std::vector<Placement>& placements, int threads) {
  changed_ = rasterizer_.draw(placements, X_LW_, threads);
  TileSet due = changed_;
  if (!drawn_) std::fill(due.begin(), due.end(), std::uint8_t{1});
  drawn_ = true;
  bounds_.update(rasterizer_.rays().grid, due, rasterizer_.inverse_depth().data());
}

bool ShadowMap::changed(const Range& range) const {
  const TileGrid& grid = rasterizer_.rays().grid;
  for (int row = range.row_min; row <= range.row_max; ++row) {
    for (int column = range.column_min; column <= range.column_max; ++column) {
      if (changed_[grid.tile_at(column, row)] != 0) return true;
    }
  }
  return false;
}

ShadowMap::Range ShadowMap::light(const TilePoints& points, TileValues& visible) const {
  const Map map{.depths = rasterizer_.inverse_depth().data(),
                .blocks = bounds_.data(),
                .R_LW = X_LW_.linear().cast<float>(),
                .p_L = X_LW_.translation().cast<float>(),
                .focal = focal_,
                .lamp_radius_m = static_cast<float>(lamp_.radius_m)};
  return range_of(light_pixels(map, points, visible), rasterizer_.rays().grid);
}

}  // namespace aprsim::render
