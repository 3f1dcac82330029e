#include "clients/ros2/dds/image_messages.hpp"

#include <algorithm>
#include <aprsim_ros2_messages.h>
#include <aprsim_ros2_type_hashes.hpp>
#include <array>
#include <cstdint>
#include <iterator>
#include <vector>

#include "clients/ros2/dds/samples.hpp"

namespace aprsim::ros2 {

TopicType image_type() {
  return {sensor_msgs_msg_dds__Image__desc, type_hash::k_sensor_msgs_msg_Image};
}
TopicType camera_info_type() {
  return {sensor_msgs_msg_dds__CameraInfo__desc, type_hash::k_sensor_msgs_msg_CameraInfo};
}

void write_image(dds_entity_t writer, const std::string& frame, const v1::Image& image) {
  const std::string encoding = "rgb8";
  constexpr std::uint32_t kBytesAPixel = 3;
  sensor_msgs_msg_dds__Image_ message{};
  message.header.stamp = stamp_of(image.sim_time());
  message.header.frame_id = text_of(frame);
  message.height = image.height_px();
  message.width = image.width_px();
  message.encoding = text_of(encoding);
  message.step = kBytesAPixel * image.width_px();
  message.data._buffer =
      const_cast<std::uint8_t*>(reinterpret_cast<const std::uint8_t*>(image.data().data()));
  message.data._length = message.data._maximum = static_cast<std::uint32_t>(image.data().size());
  write_sample(writer, &message);
}

void write_camera_info(dds_entity_t writer, const std::string& frame,
                       const v1::CameraDescription& camera, const v1::Image& image) {
  const std::string model = "plumb_bob";
  const std::vector<double> distortion(camera.distortion().begin(), camera.distortion().end());
  const double fx = camera.focal_x_px(), fy = camera.focal_y_px();
  const double cx = camera.centre_x_px(), cy = camera.centre_y_px();
  sensor_msgs_msg_dds__CameraInfo_ message{};
  message.header.stamp = stamp_of(image.sim_time());
  message.header.frame_id = text_of(frame);
  message.height = image.height_px();
  message.width = image.width_px();
  message.distortion_model = text_of(model);
  refer(message.d, distortion);
  using Matrix3 = std::array<double, 9>;
  using Matrix3x4 = std::array<double, 12>;
  std::ranges::copy(Matrix3{fx, 0, cx, 0, fy, cy, 0, 0, 1}, std::begin(message.k));
  std::ranges::copy(Matrix3{1, 0, 0, 0, 1, 0, 0, 0, 1}, std::begin(message.r));
  std::ranges::copy(Matrix3x4{fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0}, std::begin(message.p));
  write_sample(writer, &message);
}

}  // namespace aprsim::ros2
