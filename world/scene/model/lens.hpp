#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

namespace aprsim::scene {

/// A pinhole camera with the distortion of Brown (1966), as OpenCV has it. Camera frame: x to the
/// right of the picture, y down, z along the view. The middle of the pixel at the top left is
/// (0, 0).
struct Lens {
  int width_px = 0, height_px = 0;
  Eigen::Vector2d focal_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  std::array<double, 5> distortion{};  ///< k1, k2, p1, p2, k3

  /// Pixel of a direction (x, y, 1).
  [[nodiscard]] Eigen::Vector2d pixel(const Eigen::Vector2d& direction) const;
  /// Direction (x, y, 1) that a pixel shows; nullopt where the distortion cannot be inverted.
  [[nodiscard]] std::optional<Eigen::Vector2d> direction(const Eigen::Vector2d& pixel) const;
};

}  // namespace aprsim::scene
