#pragma once

#include <string>

#include "aprsim/v1/camera_service.pb.h"
#include "aprsim/v1/cell.pb.h"
#include "clients/ros2/dds/node.hpp"

/// Messages of cameras. Errors of DDS: std::runtime_error.
namespace aprsim::ros2 {

/// sensor_msgs/msg/Image.
[[nodiscard]] TopicType image_type();
/// sensor_msgs/msg/CameraInfo.
[[nodiscard]] TopicType camera_info_type();

/// `image`: of IMAGE_FORMAT_RGB. `frame`: the camera's.
void write_image(dds_entity_t writer, const std::string& frame, const v1::Image& image);
/// The lens of a camera at the time of a picture.
void write_camera_info(dds_entity_t writer, const std::string& frame,
                       const v1::CameraDescription& camera, const v1::Image& image);

}  // namespace aprsim::ros2
