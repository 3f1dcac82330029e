// Pictures that aprsim-ros2 publishes, read by Fast DDS beside the real daemon.

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/ros2/ros2_fixture.hpp"
#include "tests/support/cell_client.hpp"

namespace aprsim::test {
namespace {

const std::string kImage = "sensor_msgs::msg::dds_::Image_";
const std::string kCameraInfo = "sensor_msgs::msg::dds_::CameraInfo_";

/// A cell whose second camera has small pictures.
class Ros2Cameras : public Ros2 {
 protected:
  Ros2Cameras() : Ros2({"--scene", "fanuc_only"}), cell_(daemon_->port("grpc")) {}
  CellClient cell_;
};

TEST_F(Ros2Cameras, PicturesHaveTheCamerasSizeLensAndFrame) {
  const auto cell = cell_.cell();
  const auto camera = std::ranges::find_if(
      cell.cameras(), [](const auto& one) { return one.name() == "fanuc_tool"; });
  ASSERT_NE(camera, cell.cameras().end());
  fast_dds_->subscribe("rt/fanuc_tool/image_raw", kImage, false, {}, false);
  fast_dds_->subscribe("rt/fanuc_tool/camera_info", kCameraInfo, false, {}, false);
  fast_dds_->subscribe("rt/tf", "tf2_msgs::msg::dds_::TFMessage_", false);
  std::vector<unsigned char> image;
  ASSERT_TRUE(take_until("rt/fanuc_tool/image_raw", [&](const auto& sample) {
    image = sample;
    return true;
  }));
  const auto writer = fast_dds_->writers().at("rt/fanuc_tool/image_raw");
  EXPECT_FALSE(writer.reliable);  // as sensor data is
  EXPECT_EQ(writer.user_data,
            "typehash=RIHS01_d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47;");
  CdrReader in(image);
  in.time();
  EXPECT_EQ(in.text(), "fanuc_tool_optical_frame");
  EXPECT_EQ(in.number<std::uint32_t>(), camera->height_px());
  EXPECT_EQ(in.number<std::uint32_t>(), camera->width_px());
  EXPECT_EQ(in.text(), "rgb8");
  EXPECT_EQ(in.number<std::uint8_t>(), 0);
  EXPECT_EQ(in.number<std::uint32_t>(), 3 * camera->width_px());
  std::vector<std::uint8_t> pixels(in.number<std::uint32_t>());
  ASSERT_EQ(pixels.size(), 3U * camera->width_px() * camera->height_px());
  for (auto& value : pixels) value = in.number<std::uint8_t>();
  const auto [least, most] = std::ranges::minmax(pixels);
  EXPECT_LT(least + 50, most) << "the picture shows nothing";
  std::vector<unsigned char> info;
  ASSERT_TRUE(take_until("rt/fanuc_tool/camera_info", [&](const auto& sample) {
    info = sample;
    return true;
  }));
  CdrReader lens(info);
  lens.time();
  EXPECT_EQ(lens.text(), "fanuc_tool_optical_frame");
  EXPECT_EQ(lens.number<std::uint32_t>(), camera->height_px());
  EXPECT_EQ(lens.number<std::uint32_t>(), camera->width_px());
  EXPECT_EQ(lens.text(), "plumb_bob");
  const auto distortion = lens.doubles();
  EXPECT_TRUE(std::ranges::equal(distortion, camera->distortion()));
  std::vector<double> matrices(9 + 9 + 12);
  for (auto& value : matrices) value = lens.number<double>();
  const double fx = camera->focal_x_px(), fy = camera->focal_y_px();
  const double cx = camera->centre_x_px(), cy = camera->centre_y_px();
  EXPECT_EQ(matrices, (std::vector<double>{fx, 0, cx, 0,  fy, cy, 0, 0, 1,  1,  0, 0, 0, 1, 0,
                                           0,  0, 1,  fx, 0,  cx, 0, 0, fy, cy, 0, 0, 0, 1, 0}));
  for (int i = 0; i < 6; ++i) EXPECT_EQ(lens.number<std::uint32_t>(), 0U);  // binning, region
  EXPECT_EQ(lens.number<std::uint8_t>(), 0);
  EXPECT_TRUE(lens.at_end());
  // The camera is on the flange: its frame comes with its pictures.
  EXPECT_TRUE(take_until("rt/tf", [](const auto& sample) {
    const std::string name = "fanuc_tool_optical_frame";
    return std::ranges::search(sample, name).begin() != sample.end();
  }));
}

}  // namespace
}  // namespace aprsim::test
