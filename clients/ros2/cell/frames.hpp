#pragma once

#include <string>
#include <vector>

#include "aprsim/v1/cell.pb.h"
#include "aprsim/v1/snapshot.pb.h"

namespace aprsim::ros2 {

/// The frame in which all others are given.
inline constexpr const char* kWorldFrame = "world";

/// A frame of tf, in the world.
struct Frame {
  std::string name;
  v1::Pose in_world;  ///< metres
};

/// Frames that never move: ROBOT_base of each robot, CAMERA_optical_frame of each fixed camera.
[[nodiscard]] std::vector<Frame> fixed_frames(const v1::CellDescription& cell);

/// Frames that move: ROBOT_tool of each robot, and each body and listed tool by its name, without
/// those that are lost.
[[nodiscard]] std::vector<Frame> moving_frames(const v1::CellDescription& cell,
                                               const v1::Snapshot& snapshot);

}  // namespace aprsim::ros2
