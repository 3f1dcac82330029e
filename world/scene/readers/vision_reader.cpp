#include "world/scene/readers/vision_reader.hpp"

#include <vector>

#include <Eigen/Cholesky>

#include "world/scene/readers/reading.hpp"

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

/// Whether the image of the whole area is neither mirrored nor squeezed flat.
bool covers(const Vision& vision) {
  constexpr double kLeast = 0.1;  // of an area, in its image
  for (const double x : {vision.area_min.x(), vision.area_max.x()}) {
    for (const double y : {vision.area_min.y(), vision.area_max.y()}) {
      if (!(vision.image_slope({x, y}).determinant() > kLeast)) return false;
    }
  }
  return true;
}

/// Places and where they are reported, as a bilinear map: the best in least squares.
void read_calibration(const yaml::Node& node, Vision& vision) {
  if (!node) return;
  constexpr std::size_t kFewest = 4, kMost = 100;
  constexpr double kFlat = 1e-4;
  const std::vector<yaml::Node> points = node.items();
  if (points.size() < kFewest || points.size() > kMost) {
    node.unexpected("4 to 100 places with where they are reported");
    return;
  }
  // The normal equations.
  Eigen::Matrix4d square = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 2> reported = Eigen::Matrix<double, 4, 2>::Zero();
  for (const yaml::Node& point : points) {
    const yaml::Map keys = point.map({"at_m", "reported_m"});
    const Eigen::Vector2d at = read_xy(keys["at_m"]);
    const Eigen::Vector4d terms(1, at.x(), at.y(), at.x() * at.y());
    square += terms * terms.transpose();
    reported += terms * read_xy(keys["reported_m"]).transpose();
  }
  const Eigen::LDLT<Eigen::Matrix4d> factors(square);
  const Eigen::Vector4d pivots = factors.vectorD();
  if (!(pivots.minCoeff() > kFlat * kFlat * pivots.maxCoeff())) {
    node.error("places too much in line", "places that span the area");
    return;
  }
  const Vision before = vision;
  vision.image = factors.solve(reported).transpose();
  if (covers(vision)) return;
  node.error("an image mirrored or squeezed flat", "places reported about where they are");
  vision = before;
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
  const yaml::Map keys = node.map(
      {"frame", "area", "camera_m", "rate_hz", "latency_s", "position_noise_m",
       "rotation_noise_deg", "drop_rate", "shuffle", "occlusion", "calibration", "gear_yaw_deg",
       "tray_yaw_offset_deg", "part_tray_flip_rate", "kit_tray_flip_rate"});
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
  if (const yaml::Node yaw = keys["gear_yaw_deg"]) {
    vision.gear_yaw_rad = radians(yaw.number(yaml::between(0, 180)));
  }
  if (const yaml::Node offset = keys["tray_yaw_offset_deg"]) {
    vision.tray_yaw_offset_rad = radians(offset.number(yaml::between(-180, 180)));
  }
  vision.part_tray_flip_rate = keys["part_tray_flip_rate"].number_or(0, yaml::between(0, 1));
  vision.kit_tray_flip_rate = keys["kit_tray_flip_rate"].number_or(0, yaml::between(0, 1));
  read_calibration(keys["calibration"], vision);
  vision.shuffle = keys["shuffle"].boolean_or(vision.shuffle);
  vision.occlusion = keys["occlusion"].boolean_or(vision.occlusion);
  return vision;
}

}  // namespace aprsim::scene
