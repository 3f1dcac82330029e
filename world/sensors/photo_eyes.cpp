#include "world/sensors/photo_eyes.hpp"

#include <algorithm>
#include <cmath>

#include "world/sensors/line_of_sight.hpp"

namespace aprsim::sensors {
namespace {

// A carried part stands on the belt or in a tray on it; a part in a gripper is higher.
constexpr double kCarriedHeight = 0.08;

/// A cylinder about z of a body's frame B.
Occluder cylinder(const Eigen::Isometry3d& X_WB, double radius_m, double z_low, double z_high) {
  return {.X_WS = X_WB * Eigen::Translation3d(0, 0, 0.5 * (z_low + z_high)),
          .shape = robot::CylinderShape{radius_m, z_high - z_low}};
}

}  // namespace

PhotoEyes::PhotoEyes(const scene::Conveyor& conveyor)
    : beams_(conveyor.photo_eyes),
      X_WC_(conveyor.X_WC.isometry()),
      X_CW_(X_WC_.inverse()),
      half_length_m_(conveyor.length_m / 2),
      half_width_m_(conveyor.width_m / 2) {}

bool PhotoEyes::breaks(std::size_t eye, const scene::FreeBody& body, const Pose& X_WB) const {
  const auto& beam = beams_.at(eye);
  const Eigen::Vector3d start_W = X_WC_ * Eigen::Vector3d(beam.x_m, -half_width_m_, beam.height_m);
  const Eigen::Vector3d end_W = X_WC_ * Eigen::Vector3d(beam.x_m, half_width_m_, beam.height_m);
  const Eigen::Isometry3d X = X_WB.isometry();
  if (body.is_part()) {
    return std::ranges::any_of(body.pieces, [&](const api::Piece& piece) {
      return hides(occluder_of(piece, X), start_W, end_W);
    });
  }
  if (!body.is_gear()) {
    return hides({.X_WS = X * Eigen::Translation3d(body.slab.center()),
                  .shape = slab_shape(body.slab, body.outline)},
                 start_W, end_W);
  }
  return hides(cylinder(X, body.disc_radius_m, 0, body.disc_height_m), start_W, end_W) ||
         hides(cylinder(X, body.peg_radius_m, body.disc_height_m, body.peg_top_m), start_W, end_W);
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

void PhotoEyes::see(const scene::FreeBody& body, const Pose& X_WB) {
  if (carries(X_WB)) load_kg_ += body.mass_kg;
  for (std::size_t i = 0; i < beams_.size(); ++i) {
    broken_[i] = broken_[i] || breaks(i, body, X_WB);
  }
}

void PhotoEyes::finish() {
  for (std::size_t i = 0; i < beams_.size(); ++i) {
    if (stuck_[i]) broken_[i] = *stuck_[i];
    if (looked_ && broken_[i] && !eyes_[i].broken) ++eyes_[i].count;
    eyes_[i].broken = broken_[i];
  }
  looked_ = true;
}

}  // namespace aprsim::sensors
