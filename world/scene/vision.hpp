#pragma once

#include <Eigen/Core>

#include "world/api/pose.hpp"

namespace aprsim::scene {

/// The overhead camera that serves one robot, and the errors that it makes. Positions are in the
/// robot's vision frame V, whose x-y plane the positions on the wire belong to.
struct Vision {
  Pose X_RV;  ///< V in the robot's CRCL frame; the default makes both agree
  /// Corners of the visible area [m].
  Eigen::Vector2d area_min = {-1.2, -1.2}, area_max = {1.2, 1.2};
  Eigen::Vector3d camera_V = {0, 0, 2};  ///< a scene has another default
  double rate_hz = 10;
  double latency_s = 0.1;                    ///< from exposure until the frame is out
  double position_noise_m = 1e-4;            ///< standard deviation along x and y each
  double rotation_noise_rad = 1.7453293e-3;  ///< standard deviation
  double drop_rate = 0;                      ///< chance of an object to be missed, each frame
  bool shuffle = false;                      ///< objects in a new order in each frame
  bool occlusion = true;                     ///< arms, parts and intruders hide what is behind them
};

}  // namespace aprsim::scene
