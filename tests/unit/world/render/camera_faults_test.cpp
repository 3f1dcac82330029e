#include "world/render/camera_faults.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace aprsim::render {
namespace {

using faults::Kind;

api::InjectedFault active(Kind kind, const std::string& camera, std::vector<double> values = {}) {
  api::InjectedFault fault;
  fault.id = 7;
  fault.kind = kind;
  fault.target = camera;
  fault.state = api::FaultState::kActive;
  std::ranges::copy(values, fault.values.begin());
  return fault;
}

scene::Camera table_camera() {
  scene::Camera camera;
  camera.name = "table";
  camera.rate_hz = 10;
  camera.latency_s = 0.1;
  camera.noise = 3;
  return camera;
}

scene::Camera spoiled(std::vector<api::InjectedFault> all) {
  const api::InjectedFaults faults{std::move(all)};
  return with_faults(table_camera(), &faults).value();
}

TEST(CameraFaults, WithoutAnyACameraStaysAsItIs) {
  EXPECT_EQ(with_faults(table_camera(), nullptr)->noise, 3);
  const auto other =
      spoiled({active(Kind::kPictureOutage, "belt"), active(Kind::kPictureNoise, "belt", {8}),
               active(Kind::kCameraOutage, "table")});
  EXPECT_EQ(other.noise, 3);
  auto pending = active(Kind::kPictureOutage, "table");
  pending.state = api::FaultState::kPending;
  auto ended = active(Kind::kPictureOutage, "table");
  ended.state = api::FaultState::kEnded;
  EXPECT_EQ(spoiled({pending, ended}).noise, 3);
}

TEST(CameraFaults, AnOutageEndsThePictures) {
  const api::InjectedFaults faults{{active(Kind::kPictureOutage, "table")}};
  EXPECT_FALSE(with_faults(table_camera(), &faults));
}

TEST(CameraFaults, CombineWithTheCameraAndEachOther) {
  const auto camera = spoiled(
      {active(Kind::kPictureDirt, "table", {0.6, 12, 0.04}),
       active(Kind::kPictureFlicker, "table", {0.3, 1.7}),
       active(Kind::kPictureNoise, "table", {4}), active(Kind::kPictureLate, "table", {1}),
       active(Kind::kPictureLate, "table", {0.5}), active(Kind::kPictureSlow, "table", {2}),
       active(Kind::kPictureSlow, "table", {20}), active(Kind::kPictureQuality, "table", {10})});
  ASSERT_EQ(camera.dirt.size(), 1U);
  EXPECT_EQ(camera.dirt[0],
            (scene::LensDirt{.share = 0.6, .spots = 12, .size = 0.04, .pattern = 7}));
  ASSERT_EQ(camera.flicker.size(), 1U);
  EXPECT_EQ(camera.flicker[0], (scene::Flicker{.share = 0.3, .rate_hz = 1.7}));
  EXPECT_EQ(camera.noise, 5);
  EXPECT_NEAR(camera.latency_s, 1.6, 1e-12);
  EXPECT_EQ(camera.rate_hz, 2);
  EXPECT_EQ(camera.jpeg_quality, 10);
}

}  // namespace
}  // namespace aprsim::render
