#include "world/render/exposure.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace aprsim::render {
namespace {

scene::Camera camera_of(int width, int height) {
  scene::Camera camera;
  camera.lens.width_px = width;
  camera.lens.height_px = height;
  camera.blur_px = 0;
  return camera;
}

Picture<std::uint8_t> exposed(const scene::Camera& camera, const Picture<float>& light,
                              std::uint64_t frame = 1, std::uint64_t seed = 1) {
  const Exposure exposure(camera, seed);
  const TileGrid grid(light.width, light.height);
  Picture<std::uint8_t> out(light.width, light.height, 3);
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      exposure.expose(light, column, row, frame, out);
    }
  }
  return out;
}

Picture<float> even_light(int width, int height, float value) {
  Picture<float> light(width, height, 3);
  light.values.assign(light.values.size(), value);
  return light;
}

TEST(Exposure, GivesTheCodesOfSrgb) {
  const scene::Camera camera = camera_of(40, 20);
  EXPECT_EQ(*exposed(camera, even_light(40, 20, 0)).at(39, 19), 0);
  EXPECT_EQ(*exposed(camera, even_light(40, 20, 0.21586F)).at(39, 19), 128);
  EXPECT_EQ(*exposed(camera, even_light(40, 20, 3)).at(39, 19), 255);
}

TEST(Exposure, BlurSpreadsAPointAsANormalDistribution) {
  scene::Camera camera = camera_of(64, 48);
  camera.blur_px = 1;
  Picture<float> light(64, 48, 3);
  *light.at(32, 16) = 4;  // at the corner of four tiles
  const Picture<std::uint8_t> out = exposed(camera, light);
  const auto linear = [&](int x, int y) {
    const double s = *out.at(x, y) / 255.0;
    return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  };
  const double middle = 4 / (2 * M_PI);
  EXPECT_NEAR(linear(32, 16), middle, 0.02);
  for (const auto& [x, y] : {std::pair{31, 16}, {33, 16}, {32, 15}, {32, 17}}) {
    EXPECT_NEAR(linear(x, y), middle * std::exp(-0.5), 0.02);
  }
  EXPECT_NEAR(linear(31, 15), middle * std::exp(-1), 0.02);
}

TEST(Exposure, NoiseHasItsDeviationAndRepeatsWithSeedAndFrame) {
  scene::Camera camera = camera_of(320, 240);
  camera.noise = 3;
  const Picture<float> light = even_light(320, 240, 0.21586F);
  const Picture<std::uint8_t> out = exposed(camera, light);
  double sum = 0, squares = 0;
  for (const std::uint8_t code : out.values) {
    sum += code;
    squares += static_cast<double>(code) * code;
  }
  const auto count = static_cast<double>(out.values.size());
  const double mean = sum / count;
  EXPECT_NEAR(mean, 128, 0.1);
  EXPECT_NEAR(std::sqrt(squares / count - mean * mean), 3, 0.06);
  EXPECT_EQ(exposed(camera, light).values, out.values);
  EXPECT_NE(exposed(camera, light, 2).values, out.values);
  EXPECT_NE(exposed(camera, light, 1, 2).values, out.values);
}

double mean_of(const Picture<std::uint8_t>& picture) {
  double sum = 0;
  for (const std::uint8_t code : picture.values) sum += code;
  return sum / static_cast<double>(picture.values.size());
}

TEST(Exposure, DirtDarkensSpotsAtPlacesOfSeedAndPattern) {
  const Picture<float> light = even_light(320, 240, 0.21586F);
  scene::Camera camera = camera_of(320, 240);
  camera.dirt = {{.share = 0.8, .spots = 5, .size = 0.08}};
  const Picture<std::uint8_t> out = exposed(camera, light);
  // Pixels without a spot are as before; a spot's middle has a fifth of the light: code 59.
  EXPECT_EQ(*std::ranges::max_element(out.values), 128);
  EXPECT_GT(std::ranges::count(out.values, 128), 320 * 240 * 3 / 2);
  EXPECT_GE(*std::ranges::min_element(out.values), 58 / 5);
  EXPECT_LE(*std::ranges::min_element(out.values), 62);
  EXPECT_EQ(exposed(camera, light).values, out.values);
  EXPECT_EQ(exposed(camera, light, 2).values, out.values) << "not the frame";
  EXPECT_NE(exposed(camera, light, 1, 2).values, out.values) << "the seed";
  camera.dirt[0].pattern = 1;
  EXPECT_NE(exposed(camera, light).values, out.values) << "the pattern";
  camera.dirt[0].spots = 40;
  EXPECT_LT(mean_of(exposed(camera, light)), mean_of(out));
}

TEST(Exposure, FlickerFollowsTheTime) {
  const Picture<float> light = even_light(64, 48, 0.21586F);
  scene::Camera camera = camera_of(64, 48);
  camera.flicker = {{.share = 0.6, .rate_hz = 2}};
  Exposure exposure(camera, 1);
  Picture<std::uint8_t> out(64, 48, 3);
  const auto code_at = [&](double time_s) {
    exposure.set_flaws(camera, time_s);
    exposure.expose(light, 0, 0, 1, out);
    return static_cast<int>(*out.at(0, 0));
  };
  EXPECT_EQ(code_at(0), 128);
  EXPECT_EQ(code_at(0.25), 83);    // 0.4 of the light
  EXPECT_EQ(code_at(0.125), 108);  // 0.7 of it
  EXPECT_EQ(code_at(1000.5), 128);
  EXPECT_FALSE(exposure.set_flaws(camera, 1000.5));
  EXPECT_TRUE(exposure.set_flaws(camera, 1000.6));
}

}  // namespace
}  // namespace aprsim::render
