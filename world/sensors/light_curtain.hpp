#pragma once

#include <span>

#include <Eigen/Geometry>

#include "world/api/values/light_curtain.hpp"
#include "world/sensors/line_of_sight.hpp"

namespace aprsim::sensors {

/// Parallel beams with one output: broken while at least one beam does not reach its receiver.
/// Thread: any, once built.
class LightCurtain {
 public:
  explicit LightCurtain(const api::LightCurtainDescription& curtain);

  /// Intersects every beam with the occluders. Pure; does not allocate.
  [[nodiscard]] api::LightCurtainSnapshot measure(std::span<const Occluder> occluders) const;

 private:
  api::LightCurtainDescription curtain_;
  Eigen::Isometry3d X_WK_, X_KW_;
};

}  // namespace aprsim::sensors
