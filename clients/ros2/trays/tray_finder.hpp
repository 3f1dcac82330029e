#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <google/protobuf/duration.pb.h>

#include "aprsim/v1/camera_service.pb.h"
#include "aprsim/v1/cell.pb.h"
#include "aprsim/v1/snapshot.pb.h"
#include "clients/ros2/cell/frames.hpp"

/// Trays as a camera sees them, by the numbers and names of NIST's aprs_interfaces.
namespace aprsim::ros2 {

/// The poses of a cell's bodies at one step, without those that are lost.
struct BodyPoses {
  std::uint64_t epoch = 0, step = 0;
  google::protobuf::Duration time;
  std::map<std::string, v1::Pose> in_world;  ///< by the body's name, metres
};

[[nodiscard]] BodyPoses poses_of(const v1::Snapshot& snapshot);

/// A slot of a tray that is seen.
struct SeenSlot {
  std::string name;
  std::uint8_t size = 0;  ///< of its gear: 1 small, 2 medium, 3 large, 0 another
  bool occupied = false;
  v1::Pose in_tray;  ///< at a seated gear's grasp height, metres
};

/// A tray that is seen.
struct SeenTray {
  std::uint8_t identifier = 0;  ///< of its type, 13 to 17
  bool is_kit = false;
  std::string name;
  v1::Pose in_world;  ///< the frame on its top face, metres
  std::vector<SeenSlot> slots;
};

/// The trays of the five types that a camera sees, in the order of the cell. A tray is seen if its
/// whole outline is in the picture and hardly anything but gears hides it. A slot is occupied if
/// more than an eighth of the square about it shows gears, as aprs_vision decides.
/// `segmentation`: a picture of the camera, IMAGE_FORMAT_SEGMENTATION.
[[nodiscard]] std::vector<SeenTray> find_trays(const v1::CellDescription& cell,
                                               const BodyPoses& poses,
                                               const v1::CameraDescription& camera,
                                               const v1::Image& segmentation);

/// Frames of trays and of their slots, by their names.
[[nodiscard]] std::vector<Frame> frames_of(const std::vector<SeenTray>& trays);

}  // namespace aprsim::ros2
