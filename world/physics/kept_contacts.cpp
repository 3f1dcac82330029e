#include "world/physics/kept_contacts.hpp"

#include <cmath>

namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Isometry3d pose_in(const FreeBody& tray, const FreeBody& gear) {
  return tray.X_WB.inverse(Eigen::Isometry) * gear.X_WB;
}

/// What the farthest point of the gear moves from one pose to the other, at most.
double moved_m(const FreeBody& gear, const Isometry3d& from, const Isometry3d& to) {
  // The angle of a small rotation is the norm of what it changes the matrix by, over sqrt(2).
  const double angle = std::sqrt(0.5) * (to.linear() - from.linear()).norm();
  return (to * gear.mass.com - from * gear.mass.com).norm() + gear.radius_m * angle;
}

}  // namespace

bool KeptContacts::append(BodyIndex gear, const FreeBody& of_gear, BodyIndex tray,
                          const FreeBody& of_tray, std::vector<Contact>& out) {
  OfGear& kept = manifolds_[static_cast<std::size_t>(gear)];
  const Manifold& manifold = kept.manifold;
  if (manifold.tray != tray || kept.used + 1 < step_) return false;
  const Isometry3d X_TG = pose_in(of_tray, of_gear);
  if (!(moved_m(of_gear, manifold.X_TG, X_TG) < kMoved)) return false;
  kept.used = step_;
  for (const Point& point : manifold.points) {
    Contact contact{.a = gear, .b = tray, .pair = SurfacePair::kGearTray};
    contact.p_W = of_tray.X_WB * point.p_T;
    contact.n_W = of_tray.X_WB.linear() * point.n_T;
    contact.depth_m = point.depth_m - point.n_T.dot(X_TG * point.p_G - point.p_T);
    out.push_back(contact);
  }
  return true;
}

void KeptContacts::keep(BodyIndex gear, const FreeBody& of_gear, BodyIndex tray,
                        const FreeBody& of_tray, const std::vector<Contact>& out,
                        std::size_t first) {
  OfGear& kept = manifolds_[static_cast<std::size_t>(gear)];
  Manifold& manifold = kept.manifold;
  kept.used = step_;
  manifold.gear = gear;
  manifold.tray = tray;
  manifold.X_TG = pose_in(of_tray, of_gear);
  const Isometry3d X_GT = manifold.X_TG.inverse(Eigen::Isometry);
  const Isometry3d X_TW = of_tray.X_WB.inverse(Eigen::Isometry);
  manifold.points.clear();
  for (std::size_t i = first; i < out.size(); ++i) {
    Point& point = manifold.points.emplace_back();
    point.p_T = X_TW * out[i].p_W;
    point.n_T = X_TW.linear() * out[i].n_W;
    point.p_G = X_GT * point.p_T;
    point.depth_m = out[i].depth_m;
  }
}

KeptContacts::State KeptContacts::save() const {
  State state;
  for (const OfGear& kept : manifolds_) {
    if (kept.used == step_) state.push_back(kept.manifold);
  }
  return state;
}

void KeptContacts::restore(const State& state) {
  for (OfGear& kept : manifolds_) kept.used = 0;
  step_ = 1;
  for (const Manifold& manifold : state) {
    manifolds_[static_cast<std::size_t>(manifold.gear)] = {manifold, step_};
  }
}

}  // namespace aprsim::physics
