#include "world/sensors/camera_faults.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "world/sensors/random.hpp"

namespace aprsim::sensors {
namespace {

constexpr std::uint64_t kFlips = 0x666c697073;  // sets their numbers apart from the noise's

/// Into (-pi, pi].
double in_turn(double angle) {
  const double turn = 2 * std::numbers::pi;
  angle = std::remainder(angle, turn);
  return angle <= -std::numbers::pi ? angle + turn : angle;
}

}  // namespace

void spoil(const CameraFaults& faults, std::span<const scene::FreeBody> bodies, std::uint64_t seed,
           std::vector<api::VisionDetection>& detections) {
  std::erase_if(detections, [&](const api::VisionDetection& seen) {
    return std::ranges::find(faults.lost, seen.body) != faults.lost.end();
  });
  Random random(mix_seed(seed, kFlips));
  for (api::VisionDetection& seen : detections) {
    seen.x_m = faults.scale * seen.x_m + faults.bias_x_m;
    seen.y_m = faults.scale * seen.y_m + faults.bias_y_m;
    double yaw = seen.rotation_rad + faults.bias_yaw_rad;
    const bool kit = bodies[static_cast<std::size_t>(seen.body)].kind == api::BodyKind::kKitTray;
    if (kit && random.uniform() < faults.flip_rate) yaw += std::numbers::pi;
    if (yaw != seen.rotation_rad) seen.rotation_rad = in_turn(yaw);
    for (const auto& [body, share] : faults.scores) {
      if (seen.body == body) seen.score *= share;
    }
    for (const auto& [a, b] : faults.swapped) {
      if (seen.body == a || seen.body == b) seen.body = seen.body == a ? b : a;
    }
  }
  detections.insert(detections.end(), faults.ghosts.begin(), faults.ghosts.end());
}

}  // namespace aprsim::sensors
