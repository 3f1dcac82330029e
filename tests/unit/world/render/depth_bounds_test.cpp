#include "world/render/raster/depth_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace aprsim::render {
namespace {

constexpr int kSize = 192;
constexpr int kBlock = DepthBounds::kBlock_px;

/// A map of planes with edges between them, and of single pixels before them.
class RandomMap {
 public:
  explicit RandomMap(unsigned seed) : random_(seed), grid(kSize, kSize), depths(grid.pixels()) {
    change(0, 0, kSize, kSize);
    for (int i = 0; i < 6; ++i) change_somewhere();
    for (int i = 0; i < 3; ++i) at(pixel(), pixel()) = 3;
  }

  /// Another plane in a rectangle. Returns the tiles that it meets.
  TileSet change_somewhere() {
    const int x = pixel(), y = pixel();
    return change(x, y, std::min(kSize, x + pixel() / 2), std::min(kSize, y + pixel() / 2));
  }
  float& at(int x, int y) { return depths[grid.index(x, y)]; }

 private:
  int pixel() { return std::uniform_int_distribution<int>(0, kSize - 1)(random_); }
  float share() { return std::uniform_real_distribution<float>(-1, 1)(random_); }
  TileSet change(int x0, int y0, int x1, int y1) {
    TileSet tiles(grid.tiles(), 0);
    const float middle = 1 + 0.5F * share(), per_x = 0.01F * share(), per_y = 0.01F * share();
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) {
        at(x, y) = middle + per_x * static_cast<float>(x - x0) + per_y * static_cast<float>(y - y0);
        tiles[grid.index(x, y) / TileGrid::kPixels] = 1;
      }
    }
    return tiles;
  }

  std::mt19937 random_;

 public:
  TileGrid grid;
  std::vector<float> depths;
};

/// Least and greatest difference of the map from a block's plane within `reach` of the block.
std::pair<float, float> differences(RandomMap& map, const DepthBounds::Block& block, int column,
                                    int row, int reach) {
  float low = INFINITY, high = -INFINITY;
  for (int y = std::max(0, row * kBlock - reach); y < std::min(kSize, (row + 1) * kBlock + reach);
       ++y) {
    for (int x = std::max(0, column * kBlock - reach);
         x < std::min(kSize, (column + 1) * kBlock + reach); ++x) {
      const float u = static_cast<float>(x) - (static_cast<float>(column * kBlock) + 3.5F);
      const float v = static_cast<float>(y) - (static_cast<float>(row * kBlock) + 3.5F);
      const float rest = map.at(x, y) - (block.middle + block.per_u * u + block.per_v * v);
      low = std::min(low, rest);
      high = std::max(high, rest);
    }
  }
  return {low, high};
}

TEST(DepthBounds, HoldAllThatIsWithinReach) {
  constexpr float kRounding = 1e-5F;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    RandomMap map(seed);
    DepthBounds bounds(kSize);
    bounds.update(map.grid, TileSet(map.grid.tiles(), 1), map.depths.data());
    for (int row = 0; row < bounds.blocks(); ++row) {
      for (int column = 0; column < bounds.blocks(); ++column) {
        const DepthBounds::Block& block = bounds.data()[row * bounds.blocks() + column];
        const auto [low, high] = differences(map, block, column, row, DepthBounds::kReach_px);
        ASSERT_LE(block.low, low + kRounding) << seed << ": " << column << ", " << row;
        ASSERT_GE(block.high, high - kRounding) << seed << ": " << column << ", " << row;
        const auto [near_low, near_high] =
            differences(map, block, column, row, DepthBounds::kNear_px);
        ASSERT_LE(block.near_low, near_low + kRounding) << seed << ": " << column << ", " << row;
        ASSERT_GE(block.near_high, near_high - kRounding) << seed << ": " << column << ", " << row;
      }
    }
  }
}

TEST(DepthBounds, AreTightOnAPlane) {
  const TileGrid grid(kSize, kSize);
  std::vector<float> depths(grid.pixels());
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      depths[grid.index(x, y)] =
          0.4F + 2e-3F * static_cast<float>(x) - 1e-3F * static_cast<float>(y);
    }
  }
  DepthBounds bounds(kSize);
  bounds.update(grid, TileSet(grid.tiles(), 1), depths.data());
  for (int i = 0; i < bounds.blocks() * bounds.blocks(); ++i) {
    EXPECT_LT(bounds.data()[i].high - bounds.data()[i].low, 2e-5F);
  }
}

TEST(DepthBounds, AreThoseOfTheWholeMapAfterAnyChange) {
  RandomMap map(3);
  DepthBounds changed(kSize);
  changed.update(map.grid, TileSet(map.grid.tiles(), 1), map.depths.data());
  for (int round = 0; round < 20; ++round) {
    changed.update(map.grid, map.change_somewhere(), map.depths.data());
    DepthBounds fresh(kSize);
    fresh.update(map.grid, TileSet(map.grid.tiles(), 1), map.depths.data());
    for (int i = 0; i < fresh.blocks() * fresh.blocks(); ++i) {
      const DepthBounds::Block &a = changed.data()[i], &b = fresh.data()[i];
      ASSERT_TRUE(a.middle == b.middle && a.per_u == b.per_u && a.per_v == b.per_v &&
                  a.low == b.low && a.high == b.high && a.near_low == b.near_low &&
                  a.near_high == b.near_high)
          << "round " << round << ", block " << i;
    }
  }
}

}  // namespace
}  // namespace aprsim::render
