#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Geometry>

#include "world/api/snapshot/vision.hpp"
#include "world/scene/model/free_body.hpp"
#include "world/scene/model/vision.hpp"
#include "world/sensors/line_of_sight.hpp"
#include "world/sensors/random.hpp"

namespace aprsim::sensors {

/// Errors are normally distributed, clipped at this number of standard deviations.
inline constexpr double kNoiseLimit = 3.5;
/// Objects that lean further than this are not recognised [rad].
inline constexpr double kMaxTilt = 0.5235987755982988;

/// A camera above a robot's work area which recognises trays and gears from above, as the vision
/// systems of APRS cells do: it gives positions in the plane of the vision frame V, not images. An
/// object is detected when its origin is in the visible area, it stands upright enough, nothing is
/// between the camera and its middle, and no drop hits it. A gear that stands on a tray is part of
/// the picture of that tray and does not hide it. Parallax is assumed to be calibrated: the
/// position is the true one with the scene's calibration errors and noise. Thread: one
/// at a time.
class OverheadCamera {
 public:
  /// `X_WR` is the robot's CRCL frame.
  OverheadCamera(const scene::Vision& vision, const Eigen::Isometry3d& X_WR);

  /// Fills `out.detections` from poses as `bodies` are numbered: a pure function of its arguments.
  /// Allocates only while the detections have too little capacity.
  void detect(std::span<const scene::FreeBody> bodies, std::span<const Eigen::Isometry3d> X_WP,
              std::span<const Occluder> occluders, std::uint64_t seed, api::VisionFrame& out) const;

 private:
  [[nodiscard]] double visible_share(std::size_t body, std::span<const scene::FreeBody> bodies,
                                     std::span<const Eigen::Isometry3d> X_WP,
                                     std::span<const Occluder> occluders) const;

  [[nodiscard]] double mistaken_yaw(const scene::FreeBody& body, double yaw, Random& random) const;

  scene::Vision vision_;
  Eigen::Isometry3d X_VW_;
  Eigen::Vector3d camera_W_;
};

}  // namespace aprsim::sensors
