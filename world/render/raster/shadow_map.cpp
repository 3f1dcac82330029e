#include "world/render/raster/shadow_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace aprsim::render {
namespace {

constexpr int kSize = 1536;  // pixels along each side
constexpr int kTaps = 16, kPatterns = 16;
constexpr float kNearSearch_px = 4, kFarSearch_px = 20, kMaxPenumbra_px = 24;
constexpr float kBias = 4e-4F;  // share of the depth
constexpr float kNormalOffset_px = 1.5F;
constexpr double kMargin = 1.03;
constexpr int kBlock = 8;  // pixels along a side
constexpr int kBlocks = kSize / kBlock, kReach = static_cast<int>(kMaxPenumbra_px) / kBlock;
static_assert(kReach * kBlock >= kMaxPenumbra_px && TileGrid::kWidth % kBlock == 0 &&
              TileGrid::kHeight % kBlock == 0 && kSize % TileGrid::kWidth == 0);

using Taps = std::array<std::array<Eigen::Vector2f, kTaps>, kPatterns>;

/// Points spread evenly over the unit disc (Vogel 1979), in several turns.
Taps make_taps() {
  Taps taps;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int pattern = 0; pattern < kPatterns; ++pattern) {
    for (int i = 0; i < kTaps; ++i) {
      const double r = std::sqrt((i + 0.5) / kTaps);
      // Neighbours differ by much: 7 has no factor in common with 16.
      const double angle = golden * i + 2 * std::numbers::pi * ((7 * pattern) % kPatterns) / 16.0;
      taps[static_cast<std::size_t>(pattern)][static_cast<std::size_t>(i)] =
          Eigen::Vector2d(r * std::cos(angle), r * std::sin(angle)).cast<float>();
    }
  }
  return taps;
}

const Taps& taps() {
  static const Taps all = make_taps();
  return all;
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

/// Each block's value combined with those of all blocks within reach.
template <typename Combine>
std::vector<float> spread_out(const std::vector<float>& from, const Combine& combine) {
  std::vector<float> rows(from.size()), out(from.size());
  const auto at = [](int x, int y) { return static_cast<std::size_t>(y * kBlocks + x); };
  for (int y = 0; y < kBlocks; ++y) {
    for (int x = 0; x < kBlocks; ++x) {
      float value = from[at(x, y)];
      for (int i = std::max(0, x - kReach); i <= std::min(kBlocks - 1, x + kReach); ++i) {
        value = combine(value, from[at(i, y)]);
      }
      rows[at(x, y)] = value;
    }
  }
  for (int y = 0; y < kBlocks; ++y) {
    for (int x = 0; x < kBlocks; ++x) {
      float value = rows[at(x, y)];
      for (int i = std::max(0, y - kReach); i <= std::min(kBlocks - 1, y + kReach); ++i) {
        value = combine(value, rows[at(x, i)]);
      }
      out[at(x, y)] = value;
    }
  }
  return out;
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

}  // namespace

std::uint64_t ShadowMap::fixed_bytes() {
  // Four bounds of each block, and two while they are made.
  constexpr std::uint64_t kBounds = 6 * sizeof(float);
  return Rasterizer::fixed_bytes(lens_of(1), Rasterizer::Contents::kDepth) +
         kBounds * kBlocks * kBlocks;
}

ShadowMap::ShadowMap(const Lamp& lamp, const std::vector<Eigen::Vector3d>& lit,
                     MemoryBudget& budget)
    : lamp_(lamp),
      X_LW_(look_at(lamp.p_W, middle(lit))),
      X_LW_f_(X_LW_.cast<float>()),
      focal_(static_cast<float>(focal_of(X_LW_, lit))),
      rasterizer_(lens_of(focal_of(X_LW_, lit)), Rasterizer::Contents::kDepth, budget),
      least_(kBlocks * kBlocks, 0),
      most_(kBlocks * kBlocks, 0) {}

void ShadowMap::draw(const std::vector<Placement>& placements, int threads) {
  changed_ = rasterizer_.draw(placements, X_LW_, threads);
  const bool is_first = least_near_.empty();
  if (is_first || std::ranges::find(changed_, 1) != changed_.end()) bound_depths();
}

void ShadowMap::bound_depths() {
  const TileGrid& grid = rasterizer_.rays().grid;
  const float* depths = rasterizer_.inverse_depth().data();
  for (std::size_t tile = 0; tile < changed_.size(); ++tile) {
    if (changed_[tile] == 0) continue;
    const int x0 = static_cast<int>(tile) % grid.columns * TileGrid::kWidth;
    const int y0 = static_cast<int>(tile) / grid.columns * TileGrid::kHeight;
    for (int y = y0; y < y0 + TileGrid::kHeight; y += kBlock) {
      for (int x = x0; x < x0 + TileGrid::kWidth; x += kBlock) {
        float least = std::numeric_limits<float>::infinity(), most = 0;
        for (int i = 0; i < kBlock * kBlock; ++i) {
          const float w = depths[grid.index(x + i % kBlock, y + i / kBlock)];
          least = std::min(least, w);
          most = std::max(most, w);
        }
        const auto block = static_cast<std::size_t>(y / kBlock * kBlocks + x / kBlock);
        least_[block] = least;
        most_[block] = most;
      }
    }
  }
  least_near_ = spread_out(least_, [](float a, float b) { return std::min(a, b); });
  most_near_ = spread_out(most_, [](float a, float b) { return std::max(a, b); });
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

ShadowMap::Range ShadowMap::range(const Spread& spread) const {
  if (spread.u_min > spread.u_max) return {};
  const TileGrid& grid = rasterizer_.rays().grid;
  constexpr float kMost_px = kMaxPenumbra_px + kBlock;
  const auto tile = [](float at, int size, int count) {
    return std::clamp(static_cast<int>(std::floor(at / static_cast<float>(size))), 0, count - 1);
  };
  return {tile(spread.u_min - kMost_px, TileGrid::kWidth, grid.columns),
          tile(spread.u_max + kMost_px, TileGrid::kWidth, grid.columns),
          tile(spread.v_min - kMost_px, TileGrid::kHeight, grid.rows),
          tile(spread.v_max + kMost_px, TileGrid::kHeight, grid.rows)};
}

float ShadowMap::inverse_depth(float u, float v) const {
  const int x = std::clamp(static_cast<int>(u + 0.5F), 0, kSize - 1);
  const int y = std::clamp(static_cast<int>(v + 0.5F), 0, kSize - 1);
  return rasterizer_.inverse_depth()[rasterizer_.rays().grid.index(x, y)];
}

float ShadowMap::visibility(const Eigen::Vector3f& p_W, const Eigen::Vector3f& normal_W,
                            int pattern, Spread& spread) const {
  const float distance = (X_LW_f_ * p_W).z();
  const Eigen::Vector3f p = X_LW_f_ * (p_W + normal_W * (kNormalOffset_px * distance / focal_));
  if (!(p.z() > 0)) return 1;
  const float centre = 0.5F * (kSize - 1);
  const float u = focal_ * p.x() / p.z() + centre, v = focal_ * p.y() / p.z() + centre;
  if (!(u >= 0 && v >= 0 && u < kSize && v < kSize)) return 1;
  spread = {std::min(spread.u_min, u), std::max(spread.u_max, u), std::min(spread.v_min, v),
            std::max(spread.v_max, v)};
  const float limit = (1 + kBias) / p.z();
  const auto block = static_cast<std::size_t>(static_cast<int>(v) / kBlock * kBlocks +
                                              static_cast<int>(u) / kBlock);
  if (most_near_[block] <= limit) return 1;
  if (least_near_[block] > limit) return 0;
  const auto& offsets = taps()[static_cast<std::size_t>(pattern)];
  // Mean depth of the blockers: half of the samples near, half farther out.
  float sum = 0;
  int blockers = 0;
  for (int i = 0; i < kTaps; ++i) {
    const Eigen::Vector2f at =
        offsets[static_cast<std::size_t>(i)] * (i % 2 == 0 ? kNearSearch_px : kFarSearch_px);
    const float w = inverse_depth(u + at.x(), v + at.y());
    if (w <= limit) continue;
    sum += w;
    ++blockers;
  }
  if (blockers == 0) return 1;
  const float blocker_m = static_cast<float>(blockers) / sum;
  const float width_m =
      static_cast<float>(lamp_.radius_m) * (p.z() - blocker_m) / std::max(blocker_m, 0.01F);
  const float width_px = std::clamp(focal_ * width_m / p.z(), 0.7F, kMaxPenumbra_px);
  int lit = 0;
  for (const Eigen::Vector2f& offset : offsets) {
    lit += inverse_depth(u + width_px * offset.x(), v + width_px * offset.y()) <= limit ? 1 : 0;
  }
  return static_cast<float>(lit) / kTaps;
}

}  // namespace aprsim::render
