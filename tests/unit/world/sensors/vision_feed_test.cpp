#include "world/sensors/vision_feed.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace aprsim::sensors {
namespace {

using namespace std::chrono_literals;

class VisionFeedTest : public testing::Test {
 protected:
  VisionFeedTest() {
    bodies.resize(1);
    vision.position_noise_m = 0;
  }
  VisionFeed feed(std::uint64_t seed = 1) {
    return {vision, Eigen::Isometry3d::Identity(), 1ms, seed, 1};
  }
  /// One step with the body at x = step / 1000 m.
  void step(VisionFeed& camera, std::uint64_t now) {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translation().x() = static_cast<double>(now) / 1000;
    if (camera.due(now)) camera.expose(now, bodies, {&X, 1}, {});
    camera.advance(now);
  }

  scene::Vision vision;
  std::vector<scene::FreeBody> bodies;
};

TEST_F(VisionFeedTest, FramesComeAtTheRateAndAfterTheLatency) {
  for (const double rate : {2.0, 10.0, 30.0, 100.0}) {
    for (const double latency : {0.0, 0.04, 0.1, 0.35}) {
      vision.rate_hz = rate;
      vision.latency_s = latency;
      VisionFeed camera = feed();
      const auto period = static_cast<std::uint64_t>(std::llround(1000 / rate));
      const auto delay = static_cast<std::uint64_t>(std::llround(1000 * latency));
      for (std::uint64_t now = 0; now <= 1000; ++now) {
        step(camera, now);
        const std::uint64_t exposed = now < delay ? 0 : (now - delay) / period * period;
        ASSERT_EQ(camera.latest().number, 1 + exposed / period) << rate << ' ' << latency;
        ASSERT_EQ(camera.latest().time, exposed * 1ms);
        ASSERT_EQ(camera.latest().detections.at(0).x_m, static_cast<double>(exposed) / 1000);
      }
    }
  }
}

TEST_F(VisionFeedTest, NoiseDiffersFromFrameToFrameAndSeedToSeed) {
  vision.position_noise_m = 0.001;
  vision.latency_s = 0;
  VisionFeed first = feed(1), again = feed(1), other = feed(2);
  double before = -1;
  for (std::uint64_t now = 0; now <= 500; now += 100) {
    for (auto* camera : {&first, &again, &other}) step(*camera, now);
    const double noise = first.latest().detections.at(0).x_m - static_cast<double>(now) / 1000;
    EXPECT_EQ(first.latest().detections[0].x_m, again.latest().detections.at(0).x_m);
    EXPECT_NE(first.latest().detections[0].x_m, other.latest().detections.at(0).x_m);
    EXPECT_NE(noise, before);
    before = noise;
  }
}

}  // namespace
}  // namespace aprsim::sensors
