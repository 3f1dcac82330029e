#include "world/scene/vision_reader.hpp"

#include "world/scene/reading.hpp"

namespace aprsim::scene {
namespace {

void read_area(const yaml::Node& node, Vision& vision) {
  if (!node) return;
  const yaml::Map keys = node.map({"min_m", "max_m"});
  vision.area_min = read_xy(keys["min_m"]);
  vision.area_max = read_xy(keys["max_m"]);
  if ((vision.area_min.array() >= vision.area_max.array()).any()) {
    keys["max_m"].unexpected("both coordinates above those of min_m");
  }
}

void place_camera(Vision& vision) {
  vision.camera_V = {vision.area_max.x(), 0.5 * (vision.area_min.y() + vision.area_max.y()), 2};
}

}  // namespace

Vision read_vision(const yaml::Node& node) {
  Vision vision;
  if (!node) {
    place_camera(vision);
    return vision;
  }
  const yaml::Map keys =
      node.map({"frame", "area", "camera_m", "rate_hz", "latency_s", "position_noise_m",
                "rotation_noise_deg", "drop_rate", "shuffle", "occlusion"});
  vision.X_RV = read_pose_map(keys["frame"]);
  read_area(keys["area"], vision);
  if (const yaml::Node camera = keys["camera_m"]) {
    vision.camera_V = read_xyz(camera);
  } else {
    place_camera(vision);
  }
  // Frames on their way through the latency are kept: the limits bound their number.
  vision.rate_hz =
      keys["rate_hz"].number_or(vision.rate_hz, {.min = 0, .max = 100, .open_min = true});
  vision.latency_s = keys["latency_s"].number_or(vision.latency_s, yaml::between(0, 5));
  vision.position_noise_m =
      keys["position_noise_m"].number_or(vision.position_noise_m, yaml::between(0, 0.1));
  if (const yaml::Node noise = keys["rotation_noise_deg"]) {
    vision.rotation_noise_rad = radians(noise.number(yaml::between(0, 45)));
  }
  vision.drop_rate = keys["drop_rate"].number_or(vision.drop_rate, yaml::between(0, 1));
  vision.shuffle = keys["shuffle"].boolean_or(vision.shuffle);
  vision.occlusion = keys["occlusion"].boolean_or(vision.occlusion);
  return vision;
}

}  // namespace aprsim::scene
