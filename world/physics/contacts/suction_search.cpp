#include "world/physics/contacts/suction_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "world/physics/collision/speculative/ray_gap.hpp"

namespace aprsim::physics {
namespace {

constexpr std::size_t kRimPoints = 32;
/// Distance behind the lip at which its rays begin, and range of detection in front of it [m].
constexpr double kBehind = 1e-3, kBefore = 0.01;

using Gaps = std::array<double, kRimPoints>;

double distance_to(const FreeBody& body, const Ray& ray) {
  if (body.gear) return distance_to_gear(*body.gear, body.X_WB, ray);
  if (body.tray) return distance_to_tray(*body.tray, body.X_WB, ray);
  double nearest = kNoHit;
  if (body.is_part()) {
    for (const ConvexPiece& piece : body.part->pieces) {
      nearest = std::min(nearest, distance_to_piece(piece, body.X_WB * piece.X_BP(), ray));
    }
    return nearest;
  }
  for (const scene::Block& block : body.tool->blocks()) {
    nearest = std::min(nearest, distance_to_box(block.size, body.X_WS(block), ray));
  }
  return nearest;
}

/// The lip of one cup, and the distances to the bodies near it.
class Lip {
 public:
  Lip(const scene::VacuumCup& cup, const Eigen::Isometry3d& X_WLip) : cup_(cup) {
    // The rays start behind the lip, so that a surface pressed into it still gives a distance.
    for (std::size_t i = 0; i < kRimPoints; ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / kRimPoints;
      const Eigen::Vector3d rim(cup.radius_m * std::cos(angle), cup.radius_m * std::sin(angle),
                                -kBehind);
      rays_[i] = {X_WLip * rim, X_WLip.linear().col(2)};
    }
    gaps_.fill(kNoHit);
    const double reach = cup.radius_m + kBefore;
    const Eigen::Vector3d centre = X_WLip.translation();
    bounds_ = {centre.array() - reach, centre.array() + reach};
  }

  [[nodiscard]] const Aabb& bounds() const { return bounds_; }
  [[nodiscard]] const Gaps& gaps() const { return gaps_; }

  /// Adds a body, by its distance along a ray. Returns the share of the lip that it covers.
  template <class Distance>
  double add_body(const Distance& distance) {
    int covered = 0;
    for (std::size_t i = 0; i < kRimPoints; ++i) {
      // Several bodies may close one lip: each ray keeps the nearest surface.
      const double gap = std::max(0.0, distance(rays_[i]) - kBehind);
      gaps_[i] = std::min(gaps_[i], gap);
      if (gap <= cup_.lip_compliance_m) ++covered;
    }
    return static_cast<double>(covered) / kRimPoints;
  }

 private:
  const scene::VacuumCup& cup_;
  std::array<Ray, kRimPoints> rays_;
  Gaps gaps_;
  Aabb bounds_;
};

void find_for(PhysicsModel& model, GripperMechanism& gripper) {
  const scene::VacuumCup& cup = gripper.cup()->settings();
  Lip lip(cup, gripper.parts().X_WT());
  // The force acts on the body that covers most of the lip; ties go to the first one.
  int body = -1;
  double share = 0;
  for (const int i : model.simplification.awake()) {
    const FreeBody& free = model.body(i);
    if (!lip.bounds().meets(free.bounds)) continue;
    const double covered = lip.add_body([&](const Ray& ray) { return distance_to(free, ray); });
    if (covered <= share) continue;
    share = covered;
    body = i;
  }
  for (const StaticShape& shape : model.fixed.shapes) {
    if (!lip.bounds().meets(shape.bounds)) continue;
    const double covered = lip.add_body([&](const Ray& ray) {
      return shape.piece ? distance_to_piece(*shape.piece, shape.X_WS, ray)
                         : distance_to_box(shape.size, shape.X_WS, ray);
    });
    if (covered <= share) continue;
    share = covered;
    body = -1;
  }
  gripper.advance_suction(seal_of(cup, lip.gaps()), body, share);
}

}  // namespace

void find_suction(PhysicsModel& model) {
  for (GripperMechanism& gripper : model.grippers) {
    if (!gripper.has_suction()) {
      gripper.vent_cup();
      continue;
    }
    // An idle gripper is not solved, and a cup with suction must be.
    gripper.wake();
    find_for(model, gripper);
  }
}

void apply_suction(PhysicsModel& model) {
  for (GripperMechanism& gripper : model.grippers) {
    const Suction suction = gripper.suction();
    if (suction.force_n <= 0) continue;
    const Eigen::Isometry3d X_WLip = gripper.parts().X_WT();
    const Eigen::Vector3d p = X_WLip.translation();
    const Eigen::Vector3d f = suction.force_n * X_WLip.linear().col(2);
    // Vacuum force on the palm, and its reaction on the part: equal, opposite and on one line, so
    // that momentum is conserved.
    gripper.body_of(0).add_force_at(f, p);
    if (suction.body >= 0) model.rigid_body(suction.body)->add_force_at(-f, p);
  }
}

}  // namespace aprsim::physics
