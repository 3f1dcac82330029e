#include "world/render/raster/depth_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "world/base/simd/vec8f.hpp"
#include "world/base/simd/vector_clones.hpp"

namespace aprsim::render {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();
constexpr int kSide = DepthBounds::kBlock_px, kBorder = kLanes;
constexpr int kNear = DepthBounds::kNear_px / kSide, kReach = DepthBounds::kReach_px / kSide;
static_assert(kReach <= kBorder && TileGrid::kWidth % kSide == 0 && TileGrid::kHeight % kSide == 0);

int stride(int blocks_along) { return blocks_along + 2 * kBorder; }

/// Rows of blocks, each array at the first block.
struct Rows {
  const float *middle, *per_u, *per_v, *low, *high;
};

struct Interval {
  Vec8f low = broadcast(kFar), high = broadcast(-kFar);
  void include(const Vec8f& l, const Vec8f& h) {
    low = min(low, l);
    high = max(high, h);
  }
};

/// Bounds of eight blocks from `i` on about their own planes, within reach in the rows given.
APRSIM_VECTOR_CLONES void bound_blocks(const Rows& rows, long row_stride, int above, int below,
                                       long i, DepthBounds::Block* out) {
  const Vec8f middle = load(rows.middle + i), per_u = load(rows.per_u + i),
              per_v = load(rows.per_v + i);
  Interval close, wide;
  for (int dy = -above; dy <= below; ++dy) {
    for (int dx = -kReach; dx <= kReach; ++dx) {
      const long k = i + dy * row_stride + dx;
      const Vec8f u = load(rows.per_u + k) - per_u, v = load(rows.per_v + k) - per_v;
      const Vec8f off = load(rows.middle + k) - middle - static_cast<float>(kSide * dx) * per_u -
                        static_cast<float>(kSide * dy) * per_v;
      const Vec8f tilt = 0.5F * (kSide - 1) * (abs(u) + abs(v));
      const Vec8f low = off - tilt + load(rows.low + k), high = off + tilt + load(rows.high + k);
      wide.include(low, high);
      if (std::abs(dx) <= kNear && std::abs(dy) <= kNear) close.include(low, high);
    }
  }
  for (int lane = 0; lane < kLanes; ++lane) {
    out[lane] = {middle[lane],     per_u[lane],    per_v[lane],    close.low[lane],
                 close.high[lane], wide.low[lane], wide.high[lane]};
  }
}

/// The depths of a block, row by row.
struct Texels {
  Vec8f rows[kSide];
};
static_assert(kSide == kLanes);

struct Fit {
  float per_u = 0, per_v = 0, low = 0, high = 0;
};

/// Bounds about a plane with these slopes.
inline Fit bounds_about(const Texels& texels, float per_u, float per_v) {
  const Vec8f u = per_u * Vec8f{-3.5F, -2.5F, -1.5F, -0.5F, 0.5F, 1.5F, 2.5F, 3.5F};
  Vec8f low = broadcast(kFar), high = broadcast(-kFar);
  for (int y = 0; y < kSide; ++y) {
    const float v = per_v * (static_cast<float>(y) - 0.5F * (kSide - 1));
    const Vec8f rest = texels.rows[y] - u - v;
    low = min(low, rest);
    high = max(high, rest);
  }
  Fit out{per_u, per_v, low[0], high[0]};
  for (int lane = 1; lane < kLanes; ++lane) {
    out.low = std::min(out.low, low[lane]);
    out.high = std::max(out.high, high[lane]);
  }
  return out;
}

/// The plane through three corners; a level one where an edge crosses the block.
APRSIM_VECTOR_CLONES Fit fit_plane(const Texels& texels) {
  const float corner = texels.rows[0][0];
  const Fit plane = bounds_about(texels, (texels.rows[0][kSide - 1] - corner) / (kSide - 1),
                                 (texels.rows[kSide - 1][0] - corner) / (kSide - 1));
  const Fit level = bounds_about(texels, 0, 0);
  return level.high - level.low <= plane.high - plane.low ? level : plane;
}

}  // namespace

DepthBounds::DepthBounds(int size_px)
    : blocks_along_(size_px / kSide),
      blocks_(static_cast<std::size_t>(blocks_along_ * blocks_along_)) {
  const auto count = static_cast<std::size_t>(stride(blocks_along_) * blocks_along_);
  for (auto* values : {&own_.middle, &own_.per_u, &own_.per_v}) values->assign(count, 0);
  own_.low.assign(count, kFar);
  own_.high.assign(count, -kFar);
}

std::uint64_t DepthBounds::bytes(int size_px) {
  const auto along = static_cast<std::uint64_t>(size_px / kSide);
  return along * along * sizeof(Block) + along * (along + 2 * kBorder) * 5 * sizeof(float);
}

void DepthBounds::fit(const TileGrid& grid, const float* depths, int column, int row) {
  Texels texels;
  for (int y = 0; y < kSide; ++y) {
    texels.rows[y] = load(depths + grid.index(column * kSide, row * kSide + y));
  }
  const Fit fit = fit_plane(texels);
  const auto i = static_cast<std::size_t>(row * stride(blocks_along_) + kBorder + column);
  own_.middle[i] = 0.5F * (fit.low + fit.high);
  own_.per_u[i] = fit.per_u;
  own_.per_v[i] = fit.per_v;
  own_.low[i] = fit.low - own_.middle[i];
  own_.high[i] = fit.high - own_.middle[i];
}

void DepthBounds::bound_row(int row) {
  const Rows rows{own_.middle.data(), own_.per_u.data(), own_.per_v.data(), own_.low.data(),
                  own_.high.data()};
  const int above = std::min(kReach, row), below = std::min(kReach, blocks_along_ - 1 - row);
  for (int column = 0; column < blocks_along_; column += kLanes) {
    bound_blocks(rows, stride(blocks_along_), above, below,
                 static_cast<long>(row) * stride(blocks_along_) + kBorder + column,
                 blocks_.data() + static_cast<std::ptrdiff_t>(row) * blocks_along_ + column);
  }
}

void DepthBounds::update(const TileGrid& grid, const TileSet& changed, const float* depths) {
  std::vector<std::uint8_t> due(static_cast<std::size_t>(blocks_along_), 0);
  for (std::size_t tile = 0; tile < changed.size(); ++tile) {
    if (changed[tile] == 0) continue;
    const int column = static_cast<int>(tile) % grid.columns * TileGrid::kWidth / kSide;
    const int row = static_cast<int>(tile) / grid.columns * TileGrid::kHeight / kSide;
    for (int i = 0; i < TileGrid::kPixels / (kSide * kSide); ++i) {
      constexpr int kAcross = TileGrid::kWidth / kSide;
      fit(grid, depths, column + i % kAcross, row + i / kAcross);
    }
    const int last = std::min(blocks_along_ - 1, row + TileGrid::kHeight / kSide - 1 + kReach);
    for (int r = std::max(0, row - kReach); r <= last; ++r) due[static_cast<std::size_t>(r)] = 1;
  }
  for (int row = 0; row < blocks_along_; ++row) {
    if (due[static_cast<std::size_t>(row)] != 0) bound_row(row);
  }
}

}  // namespace aprsim::render
