#pragma once

#include <array>
#include <cstdint>

#include "world/render/picture.hpp"
#include "world/render/raster/tiles.hpp"
#include "world/scene/model/camera.hpp"

namespace aprsim::render {

/// A camera's sensor: from linear light to 8-bit sRGB codes, with the lens's blur, exposure and
/// noise. A pixel's noise depends on the seed, the frame and the pixel alone.
class Exposure {
 public:
  Exposure(const scene::Camera& camera, std::uint64_t seed);

  /// Distance over which a pixel's light reaches others.
  [[nodiscard]] int reach_px() const { return reach_; }
  [[nodiscard]] bool is_noisy() const { return noise_ > 0; }
  /// Writes one tile of `out`.
  void expose(const Picture<float>& light, int column, int row, std::uint64_t frame,
              Picture<std::uint8_t>& out) const;

 private:
  static constexpr int kMaxReach = 6;
  void encode(const float* light, int x, int y, std::uint64_t frame, std::uint8_t* out) const;

  std::array<float, 2 * kMaxReach + 1> kernel_{};
  int reach_ = 0;
  float exposure_ = 1, noise_ = 0;
  std::uint64_t seed_ = 0;
};

}  // namespace aprsim::render
