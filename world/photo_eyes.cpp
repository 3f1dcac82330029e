#include "world/photo_eyes.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::world {
namespace {

// What the belt carries stands on it or in a tray on it; a part in a gripper is higher.
constexpr double kCarriedHeight = 0.08;

/// A stretch [from, to] of a beam, both as fractions of its length.
struct Stretch {
  double from = 0, to = 1;
  [[nodiscard]] bool empty() const { return from > to; }
  /// Cuts off what lies outside low <= start + t * way <= high.
  void clip(double start, double way, double low, double high) {
    if (way == 0) {
      if (start < low || start > high) to = from - 1;
      return;
    }
    const double a = (low - start) / way, b = (high - start) / way;
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
};

bool meets_box(const Eigen::Vector3d& start, const Eigen::Vector3d& way, const Eigen::Vector3d& low,
               const Eigen::Vector3d& high) {
  Stretch inside;
  for (int i = 0; i < 3 && !inside.empty(); ++i) inside.clip(start[i], way[i], low[i], high[i]);
  return !inside.empty();
}

/// A cylinder about z from z = low to z = high.
bool meets_cylinder(const Eigen::Vector3d& start, const Eigen::Vector3d& way, double radius,
                    double low, double high) {
  Stretch inside;
  inside.clip(start.z(), way.z(), low, high);
  if (inside.empty()) return false;
  // Nearest to the axis within the stretch.
  const Eigen::Vector2d s = start.head<2>(), w = way.head<2>();
  const double square = w.squaredNorm();
  const double nearest = square > 0 ? -s.dot(w) / square : inside.from;
  const double t = std::clamp(nearest, inside.from, inside.to);
  return (s + t * w).norm() <= radius;
}

}  // namespace

PhotoEyes::PhotoEyes(const api::ConveyorDescription& conveyor)
    : beams_(conveyor.photo_eyes),
      X_CW_(conveyor.X_WC.isometry().inverse()),
      half_length_m_(conveyor.length_m / 2),
      half_width_m_(conveyor.width_m / 2) {}

bool PhotoEyes::breaks(std::size_t eye, const api::BodyDescription& body, const Pose& X_WB) const {
  const Eigen::Isometry3d X_BC = (X_CW_ * X_WB.isometry()).inverse();
  const auto& beam = beams_.at(eye);
  const Eigen::Vector3d start = X_BC * Eigen::Vector3d(beam.x_m, -half_width_m_, beam.height_m);
  const Eigen::Vector3d end = X_BC * Eigen::Vector3d(beam.x_m, half_width_m_, beam.height_m);
  const Eigen::Vector3d way = end - start;
  if (body.kind != api::BodyKind::kGear) return meets_box(start, way, body.box_min, body.box_max);
  return meets_cylinder(start, way, body.disc_radius_m, 0, body.disc_height_m) ||
         meets_cylinder(start, way, body.peg_radius_m, body.disc_height_m, body.peg_top_m);
}

bool PhotoEyes::carries(const Pose& X_WB) const {
  const Eigen::Vector3d p_C = X_CW_ * X_WB.p;
  return std::abs(p_C.x()) <= half_length_m_ && std::abs(p_C.y()) <= half_width_m_ &&
         p_C.z() >= 0 && p_C.z() <= kCarriedHeight;
}

void PhotoEyes::begin() {
  broken_.fill(false);
  load_kg_ = 0;
}

void PhotoEyes::see(const api::BodyDescription& body, const Pose& X_WB) {
  if (carries(X_WB)) load_kg_ += body.mass_kg;
  for (std::size_t i = 0; i < beams_.size(); ++i) {
    broken_[i] = broken_[i] || breaks(i, body, X_WB);
  }
}

void PhotoEyes::finish() {
  for (std::size_t i = 0; i < beams_.size(); ++i) {
    if (looked_ && broken_[i] && !eyes_[i].broken) ++eyes_[i].count;
    eyes_[i].broken = broken_[i];
  }
  looked_ = true;
}

}  // namespace aprsim::world
