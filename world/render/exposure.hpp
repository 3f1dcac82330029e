#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "world/render/picture.hpp"
#include "world/render/raster/tiles.hpp"
#include "world/scene/model/camera.hpp"

namespace aprsim::render {

/// A camera's lens and sensor: from linear light to 8-bit sRGB codes, with blur, dirt, flicker,
/// exposure and noise. A pixel's noise depends on the seed, the frame and the pixel alone, the
/// places of dirt on the seed and the dirt's pattern.
class Exposure {
 public:
  static constexpr int kChannels = 3, kLineValues = kChannels * TileGrid::kWidth;
  /// A tile's row, channel by channel.
  struct alignas(32) Line : std::array<float, kLineValues> {};

  Exposure(const scene::Camera& camera, std::uint64_t seed);

  /// Takes over dirt, flicker and noise of a camera, at a simulated time. Returns whether pictures
  /// become others than before, by noise alone excepted.
  bool set_flaws(const scene::Camera& camera, double time_s);

  /// Distance over which a pixel's light reaches others.
  [[nodiscard]] int reach_px() const { return reach_; }
  [[nodiscard]] bool is_noisy() const { return noise_ > 0; }
  /// Writes one tile of `out`.
  void expose(const Picture<float>& light, int column, int row, std::uint64_t frame,
              Picture<std::uint8_t>& out) const;

 private:
  static constexpr int kMaxReach = 6;
  void encode(const Line& light, int x0, int y, int pixels, std::uint64_t frame,
              std::uint8_t* out) const;
  void copy_row(const Picture<float>& light, int x, int y, int pixels, float* to) const;
  [[nodiscard]] float passing(int x, int y) const;
  void spread_dirt();

  std::array<float, 2 * kMaxReach + 1> kernel_{};
  int reach_ = 0;
  int width_ = 0, height_ = 0;
  float exposure_ = 1;  // of the camera
  float gain_ = 1;      // with the flicker at present
  float noise_ = 0;
  std::uint64_t seed_ = 0;
  std::vector<scene::LensDirt> dirt_;
  std::vector<std::uint8_t> passing_;  // share of the light of each pixel, of 255; empty = no dirt
};

}  // namespace aprsim::render
