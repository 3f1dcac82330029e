#include "world/sensors/overhead_camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace aprsim::sensors {
namespace {

/// Trays whose sides differ by less look alike at every quarter of a turn [m].
constexpr double kSquare = 2e-3;

/// Points of an object's top that a camera tests: the middle first, then around it.
using Points = std::array<Eigen::Vector3d, 5>;

Points points_of(const scene::FreeBody& body) {
  if (body.is_gear()) {
    const double r = 0.9 * body.disc_radius_m, z = body.disc_height_m;
    return {{{0, 0, z}, {r, 0, z}, {0, r, z}, {-r, 0, z}, {0, -r, z}}};
  }
  const Eigen::Vector3d &a = body.slab.min(), &b = body.slab.max();
  const double z = b.z();
  Points points{{{0.5 * (a.x() + b.x()), 0.5 * (a.y() + b.y()), z},
                 {a.x(), a.y(), z},
                 {b.x(), a.y(), z},
                 {b.x(), b.y(), z},
                 {a.x(), b.y(), z}}};
  if (!body.outline) return points;
  // The corners of the outline nearest to those of the box around it.
  const auto& corners = body.outline->corners;
  for (std::size_t k = 1; k < points.size(); ++k) {
    const Eigen::Vector2d of_box = points[k].head<2>();
    const auto nearer = [&of_box](const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
      return (p - of_box).squaredNorm() < (q - of_box).squaredNorm();
    };
    points[k].head<2>() = *std::min_element(corners.begin(), corners.end(), nearer);
  }
  return points;
}

/// Whether an occluder is part of a body, or of a gear or part that stands on that body, a tray.
bool belongs_to(const Occluder& occluder, std::size_t body, std::span<const scene::FreeBody> bodies,
                std::span<const Eigen::Isometry3d> X_WP) {
  if (occluder.body < 0) return false;
  const auto other = static_cast<std::size_t>(occluder.body);
  if (other == body) return true;
  return bodies[body].is_tray() && !bodies[other].is_tray() &&
         scene::stands_on(X_WP[other], X_WP[body], bodies[body]);
}

/// Whether an occluder is a tray that shows the middle of a part in one of its pockets.
bool shows(const Occluder& occluder, const Eigen::Vector3d& camera_W,
           const Eigen::Vector3d& middle_W, std::span<const scene::FreeBody> bodies,
           std::span<const Eigen::Isometry3d> X_WP) {
  if (occluder.body < 0) return false;
  const auto tray = static_cast<std::size_t>(occluder.body);
  if (bodies[tray].outlined.empty()) return false;
  const Eigen::Isometry3d X_PW = X_WP[tray].inverse(Eigen::Isometry);
  return bodies[tray].shows_in_pocket(X_PW * camera_W, X_PW * middle_W);
}

/// Angle of the rotation nearest to a map of the plane.
double turn_of(const Eigen::Matrix2d& map) {
  return std::atan2(map(1, 0) - map(0, 1), map(0, 0) + map(1, 1));
}

/// Into (-pi, pi], as the lab's cameras send angles; a client folds part trays further by itself.
double wrapped(double angle) {
  const double turn = 2 * std::numbers::pi;
  angle = std::remainder(angle, turn);
  return angle <= -std::numbers::pi ? angle + turn : angle;
}

}  // namespace

OverheadCamera::OverheadCamera(const scene::Vision& vision, const Eigen::Isometry3d& X_WR)
    : vision_(vision),
      X_VW_((X_WR * vision.X_RV.isometry()).inverse()),
      camera_W_(X_WR * vision.X_RV.isometry() * vision.camera_V) {}

void OverheadCamera::detect(std::span<const scene::FreeBody> bodies,
                            std::span<const Eigen::Isometry3d> X_WP,
                            std::span<const Occluder> occluders, std::uint64_t seed,
                            api::VisionFrame& out) const {
  out.detections.clear();
  if (!vision_.occlusion) occluders = {};
  Random random(seed);
  for (std::size_t i = 0; i < X_WP.size(); ++i) {
    // Drawn for every object, detected or not, so that no object changes the noise of others.
    const bool dropped = random.uniform() < vision_.drop_rate;
    const double dx = random.gaussian(kNoiseLimit) * vision_.position_noise_m;
    const double dy = random.gaussian(kNoiseLimit) * vision_.position_noise_m;
    const double turn = random.gaussian(kNoiseLimit) * vision_.rotation_noise_rad;
    const Eigen::Isometry3d X_VP = X_VW_ * X_WP[i];
    const Eigen::Vector2d xy = X_VP.translation().head<2>();
    const double yaw = mistaken_yaw(
        bodies[i], std::atan2(X_VP(1, 0), X_VP(0, 0)) + turn_of(vision_.image_slope(xy)), random);
    if (dropped || (xy.array() < vision_.area_min.array()).any() ||
        (xy.array() > vision_.area_max.array()).any() || X_VP(2, 2) < std::cos(kMaxTilt)) {
      continue;
    }
    const double score = visible_share(i, bodies, X_WP, occluders);
    if (score == 0) continue;
    const Eigen::Vector2d image =
        vision_.image * Eigen::Vector4d(1, xy.x(), xy.y(), xy.x() * xy.y());
    out.detections.push_back({.body = static_cast<int>(i),
                              .x_m = image.x() + dx,
                              .y_m = image.y() + dy,
                              .rotation_rad = wrapped(yaw + turn),
                              .score = score});
  }
  if (!vision_.shuffle) return;
  for (std::size_t left = out.detections.size(); left > 1; --left) {
    std::swap(out.detections[left - 1], out.detections[random.below(left)]);
  }
}

/// The reported angle; of a symmetric object any equivalent one. A body always draws the same
/// count of numbers.
double OverheadCamera::mistaken_yaw(const scene::FreeBody& body, double yaw, Random& random) const {
  if (body.is_gear()) {
    return vision_.gear_yaw_rad ? *vision_.gear_yaw_rad * (2 * random.uniform() - 1) : yaw;
  }
  if (body.is_part()) return yaw;
  yaw += vision_.tray_yaw_offset_rad;
  const double rate = body.kind == api::BodyKind::kKitTray ? vision_.kit_tray_flip_rate
                                                           : vision_.part_tray_flip_rate;
  if (rate == 0 || random.uniform() >= rate) return yaw;
  const Eigen::Vector3d size = body.slab.sizes();
  const bool square = std::abs(size.x() - size.y()) < kSquare;
  return yaw + (square ? std::numbers::pi / 2 : std::numbers::pi);
}

/// 0 when the middle is hidden, else the share of points in sight.
double OverheadCamera::visible_share(std::size_t body, std::span<const scene::FreeBody> bodies,
                                     std::span<const Eigen::Isometry3d> X_WP,
                                     std::span<const Occluder> occluders) const {
  Points points = points_of(bodies[body]);
  double extent = 0;
  for (auto& point : points) {
    point = X_WP[body] * point;
    extent = std::max(extent, (point - points[0]).norm());
  }
  std::array<bool, std::tuple_size_v<Points>> hidden{};
  for (const auto& occluder : occluders) {
    const double distance = distance_to_segment(occluder.X_WS.translation(), camera_W_, points[0]);
    if (distance > occluder.bound_m + extent || belongs_to(occluder, body, bodies, X_WP)) continue;
    if (shows(occluder, camera_W_, points[0], bodies, X_WP)) continue;
    for (std::size_t k = 0; k < points.size(); ++k) {
      hidden[k] = hidden[k] || hides(occluder, camera_W_, points[k]);
    }
    if (hidden[0]) return 0;
  }
  double seen = 0;
  for (const bool is_hidden : hidden) seen += is_hidden ? 0 : 1;
  return seen / static_cast<double>(points.size());
}

}  // namespace aprsim::sensors
