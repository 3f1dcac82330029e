#include "world/render/raster/depth_bounds.hpp"

#include <algorithm>
#include <array>
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
  std::array<float, kSide * kSide> w;
  for (int y = 0; y < kSide; ++y) {
    std::copy_n(depths + grid.index(column * kSide, row * kSide + y), kSide, w.data() + kSide * y);
  }
  constexpr float kHalf = 0.5F * (kSide - 1);
  const auto bounds = [&w](float u, float v) {
    float low = kFar, high = -kFar;
    for (int i = 0; i < kSide * kSide; ++i) {
      const float rest = w[static_cast<std::size_t>(i)] -
                         u * (static_cast<float>(i % kSide) - kHalf) -
                         v * (static_cast<float>(i / kSide) - kHalf);
      low = std::min(low, rest);
      high = std::max(high, rest);
    }
    return std::pair{low, high};
  };
  // Through three corners; level where an edge crosses the block.
  float u = (w[kSide - 1] - w[0]) / (kSide - 1);
  float v = (w[kSide * (kSide - 1)] - w[0]) / (kSide - 1);
  auto [low, high] = bounds(u, v);
  const auto [level_low, level_high] = bounds(0, 0);
  if (level_high - level_low <= high - low) {
    u = v = 0;
    low = level_low;
    high = level_high;
  }
  const auto i = static_cast<std::size_t>(row * stride(blocks_along_) + kBorder + column);
  const float middle = 0.5F * (low + high);
  own_.middle[i] = middle;
  own_.per_u[i] = u;
  own_.per_v[i] = v;
  own_.low[i] = low - middle;
  own_.high[i] = high - middle;
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
