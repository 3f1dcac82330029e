#include "world/scene/readers/camera_reader.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "world/scene/readers/reading.hpp"

namespace aprsim::scene {
namespace {

constexpr std::int64_t kLeastPixels = 16, kMostPixels = 4096;
constexpr double kMaxFocal_px = 1e5;
constexpr int kDefaultWidth_px = 1280, kDefaultHeight_px = 720;

/// A camera frame at `from` that looks at `at`; the picture's upper edge is towards `up`.
Pose look_at(const Eigen::Vector3d& from, const Eigen::Vector3d& at, const Eigen::Vector3d& up) {
  const Eigen::Vector3d z = (at - from).normalized();
  Eigen::Vector3d x = z.cross(up);
  if (!(x.norm() > 1e-6)) x = z.unitOrthogonal();
  x.normalize();
  Eigen::Matrix3d R;
  R << x, z.cross(x), z;
  return {from, Eigen::Quaterniond(R)};
}

/// Corners of what a robot's vision covers, in the world.
std::vector<Eigen::Vector3d> area_of(const Robot& robot, const Eigen::Isometry3d& X_WV) {
  std::vector<Eigen::Vector3d> corners;
  for (const double x : {robot.vision.area_min.x(), robot.vision.area_max.x()}) {
    for (const double y : {robot.vision.area_min.y(), robot.vision.area_max.y()}) {
      corners.emplace_back(X_WV * Eigen::Vector3d(x, y, 0));
    }
  }
  return corners;
}

/// One entry of the list.
class CameraReader {
 public:
  CameraReader(const yaml::Map& keys, const Scene& scene) : keys_(keys), scene_(scene) {}

  Camera read() {
    camera_.name = read_name(keys_["name"]);
    read_lens();
    read_robot();
    read_carrier();
    read_pose_keys();
    read_focal();
    read_sensor();
    check_lens();
    return camera_;
  }

 private:
  void read_lens() {
    Lens& lens = camera_.lens;
    lens.width_px = kDefaultWidth_px;
    lens.height_px = kDefaultHeight_px;
    if (const yaml::Node size = keys_["resolution_px"]) {
      const std::vector<yaml::Node> items = size.items();
      if (items.size() != 2) return size.unexpected("width and height");
      lens.width_px = static_cast<int>(items[0].integer(kLeastPixels, kMostPixels));
      lens.height_px = static_cast<int>(items[1].integer(kLeastPixels, kMostPixels));
    }
    lens.centre_px = {0.5 * (lens.width_px - 1), 0.5 * (lens.height_px - 1)};
    if (const yaml::Node centre = keys_["centre_px"]) {
      const auto at = centre.numbers<2>(yaml::between(-kMaxFocal_px, kMaxFocal_px));
      lens.centre_px = {at[0], at[1]};
    }
    if (const yaml::Node distortion = keys_["distortion"]) {
      const auto terms = distortion.numbers(1, lens.distortion.size(), yaml::between(-100, 100));
      std::ranges::copy(terms, lens.distortion.begin());
    }
  }

  /// Place, direction and rate of the camera that a robot's vision has.
  void read_robot() {
    const yaml::Node over = keys_["over"];
    if (!over) return;
    camera_.robot = robot_named(over);
    if (camera_.robot < 0) return;
    const Robot& robot = scene_.robots[static_cast<std::size_t>(camera_.robot)];
    const Eigen::Isometry3d X_WV =
        robot.X_WB.isometry() * robot.X_BR.isometry() * robot.vision.X_RV.isometry();
    covered_ = area_of(robot, X_WV);
    const Eigen::Vector3d middle = (covered_.front() + covered_.back()) / 2;
    camera_.X_PC = look_at(X_WV * robot.vision.camera_V, middle, X_WV.linear().col(0));
    camera_.rate_hz = std::min(robot.vision.rate_hz, kMaxRate_hz);
    camera_.latency_s = robot.vision.latency_s;
  }

  /// Index of the robot that a key names; reports an unknown one and returns -1.
  [[nodiscard]] int robot_named(const yaml::Node& node) const {
    const std::string name = node.text();
    const auto robot = std::ranges::find(scene_.robots, name, &Robot::name);
    if (robot != scene_.robots.end()) return static_cast<int>(robot - scene_.robots.begin());
    std::vector<std::string> names;
    for (const Robot& known : scene_.robots) names.push_back(known.name);
    report_unknown(node, name, "robot", names);
    return -1;
  }

  /// The flange that it is mounted on.
  void read_carrier() {
    const yaml::Node on = keys_["on_flange"];
    if (!on) return;
    camera_.carrier = robot_named(on);
    if (const yaml::Node over = keys_["over"]) over.unexpected("either over or on_flange");
    if (const yaml::Node at = keys_["look_at_m"]) {
      at.unexpected("rpy_deg for a camera on a flange");
    }
  }

  void read_pose_keys() {
    const yaml::Node xyz = keys_["xyz_m"], rpy = keys_["rpy_deg"], at = keys_["look_at_m"];
    if (rpy && at) at.unexpected("either rpy_deg or look_at_m");
    if (keys_["on_flange"]) {
      if (!xyz || !rpy) {
        return keys_.node().error("a camera on a flange without a pose",
                                  "the keys xyz_m and rpy_deg, in the flange");
      }
      camera_.X_PC = read_pose(xyz, rpy);
      return;
    }
    if (!xyz && !rpy && !at) {
      if (covered_.empty()) keys_.node().error("a camera without a place", "the key over or xyz_m");
      return;
    }
    const Eigen::Vector3d place = xyz ? read_xyz(xyz) : camera_.X_PC.p;
    if (at) {
      const Eigen::Vector3d target = read_xyz(at);
      if (!((target - place).norm() > 1e-3)) at.unexpected("a place away from the camera");
      camera_.X_PC = look_at(place, target, Eigen::Vector3d::UnitY());
      return;
    }
    camera_.X_PC.p = place;
    if (rpy) camera_.X_PC.q = read_pose(xyz, rpy).q;
    if (!rpy && covered_.empty()) {
      keys_.node().error("a camera without a direction", "the key rpy_deg or look_at_m");
    }
  }

  /// Without one it fits the area of the robot's vision into the picture.
  void read_focal() {
    constexpr yaml::Range kFocal{.min = 1, .max = kMaxFocal_px};
    const yaml::Node focal = keys_["focal_px"];
    if (focal && focal.is_list()) {
      const auto both = focal.numbers<2>(kFocal);
      camera_.lens.focal_px = {both[0], both[1]};
      return;
    }
    double f = fitting_focal();
    if (focal) f = focal.number(kFocal);
    if (!(f > 0)) {
      keys_.node().error("a camera without focal_px", "it, or the key over and a view of its area");
    }
    camera_.lens.focal_px = {f, f};
  }

  [[nodiscard]] double fitting_focal() const {
    constexpr double kUsed = 0.47;  // of the picture, from its middle
    double focal = covered_.empty() ? 0 : kMaxFocal_px;
    const Eigen::Isometry3d X_CW = camera_.X_PC.isometry().inverse();
    for (const Eigen::Vector3d& p_W : covered_) {
      const Eigen::Vector3d p = X_CW * p_W;
      if (!(p.z() > 0)) return 0;
      focal = std::min({focal, kUsed * camera_.lens.width_px * p.z() / std::abs(p.x()),
                        kUsed * camera_.lens.height_px * p.z() / std::abs(p.y())});
    }
    return focal;
  }

  void read_sensor() {
    camera_.rate_hz = keys_["rate_hz"].number_or(camera_.rate_hz,
                                                 {.min = 0, .max = kMaxRate_hz, .open_min = true});
    camera_.latency_s = keys_["latency_s"].number_or(camera_.latency_s, yaml::between(0, 5));
    camera_.jpeg_quality =
        static_cast<int>(keys_["jpeg_quality"].integer_or(camera_.jpeg_quality, 1, 100));
    camera_.exposure =
        keys_["exposure"].number_or(camera_.exposure, {.min = 0, .max = 16, .open_min = true});
    camera_.noise = keys_["noise"].number_or(camera_.noise, yaml::between(0, 50));
    camera_.blur_px = keys_["blur_px"].number_or(camera_.blur_px, yaml::between(0, 2));
    read_flaws();
  }

  void read_flaws() {
    constexpr yaml::Range kShare{.min = 0, .max = 1};
    if (const yaml::Node node = keys_["dirt"]) {
      const yaml::Map keys = node.map({"share", "spots", "size"});
      camera_.dirt.push_back({.share = keys["share"].number(kShare),
                              .spots = static_cast<int>(keys["spots"].integer_or(12, 1, 100)),
                              .size = keys["size"].number_or(0.04, yaml::between(0.001, 1))});
    }
    if (const yaml::Node node = keys_["flicker"]) {
      const yaml::Map keys = node.map({"share", "rate_hz"});
      camera_.flicker.push_back(
          {.share = keys["share"].number(kShare),
           .rate_hz = keys["rate_hz"].number_or(1.7, yaml::between(0.001, 500))});
    }
  }

  /// Every pixel along the picture's edge has a direction.
  void check_lens() const {
    const Lens& lens = camera_.lens;
    if (!(lens.focal_px.minCoeff() > 0)) return;
    const auto has = [&lens](int u, int v) { return lens.direction({u, v}).has_value(); };
    bool all = true;
    for (int u = 0; u < lens.width_px && all; ++u) all = has(u, 0) && has(u, lens.height_px - 1);
    for (int v = 0; v < lens.height_px && all; ++v) all = has(0, v) && has(lens.width_px - 1, v);
    if (all) return;
    const yaml::Node distortion = keys_["distortion"];
    (distortion ? distortion : keys_.node())
        .error("a lens that folds the picture within its frame",
               "a distortion that grows outwards up to the corners");
  }

  static constexpr double kMaxRate_hz = 60;

  const yaml::Map& keys_;
  const Scene& scene_;
  Camera camera_;
  std::vector<Eigen::Vector3d> covered_;  // by the robot's vision
};

}  // namespace

void read_cameras(const yaml::Node& node, Scene& scene) {
  std::set<std::string> names;
  for (const yaml::Node& item : node.items()) {
    if (scene.cameras.size() == kMaxCameras) {
      return item.error("one camera more", "at most " + std::to_string(kMaxCameras) + " cameras");
    }
    const yaml::Map keys =
        item.map({"name", "over", "xyz_m", "rpy_deg", "look_at_m", "resolution_px", "focal_px",
                  "centre_px", "distortion", "rate_hz", "latency_s", "jpeg_quality", "exposure",
                  "noise", "blur_px", "on_flange", "dirt", "flicker"});
    Camera camera = CameraReader(keys, scene).read();
    if (!names.insert(camera.name).second) {
      keys["name"].error("a second camera " + camera.name, "unique names");
    }
    scene.cameras.push_back(std::move(camera));
  }
}

}  // namespace aprsim::scene
