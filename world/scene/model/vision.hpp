#pragma once

#include <optional>

#include <Eigen/Core>

#include "world/api/values/pose.hpp"

namespace aprsim::scene {

/// The overhead camera that serves one robot, and the errors that it makes. Positions are in the
/// robot's vision frame V, whose x-y plane the positions on the wire belong to.
struct Vision {
  Pose X_RV;  ///< V in the robot's CRCL frame; the default makes both agree
  /// Corners of the visible area [m].
  Eigen::Vector2d area_min = {-1.2, -1.2}, area_max = {1.2, 1.2};
  Eigen::Vector3d camera_V = {0, 0, 2};  ///< a scene has another default
  /// Errors of its calibration: what is at (x, y) is reported at image * (1, x, y, x y) [m].
  Eigen::Matrix<double, 2, 4> image{{0, 1, 0, 0}, {0, 0, 1, 0}};
  /// How the image of a place moves with the place, a 2 x 2 matrix.
  [[nodiscard]] Eigen::Matrix2d image_slope(const Eigen::Vector2d& at) const {
    Eigen::Matrix2d slope;
    slope << image.col(1) + image.col(3) * at.y(), image.col(2) + image.col(3) * at.x();
    return slope;
  }
  double rate_hz = 10;
  double latency_s = 0.1;                    ///< from exposure until the frame is out
  double position_noise_m = 1e-4;            ///< standard deviation along x and y each
  double rotation_noise_rad = 1.7453293e-3;  ///< standard deviation
  double drop_rate = 0;                      ///< chance of an object to be missed, each frame
  /// A gear looks the same at many angles: the one reported is anywhere within +- this, anew each
  /// frame; none = the true one.
  std::optional<double> gear_yaw_rad;
  double tray_yaw_offset_rad = 0;  ///< of the yaw reported for a tray: another zero than ours
  /// Chance of a tray to be taken for itself turned by half, a square one by a quarter, each frame.
  double part_tray_flip_rate = 0, kit_tray_flip_rate = 0;
  bool shuffle = false;   ///< objects in a new order in each frame
  bool occlusion = true;  ///< arms, parts and intruders hide what is behind them
};

}  // namespace aprsim::scene
