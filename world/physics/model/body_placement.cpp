#include "world/physics/model/body_placement.hpp"

#include <algorithm>

#include "world/physics/bodies/divergence.hpp"

namespace aprsim::physics {
namespace {

// A placed body may overlap others by less than kOverlap; a raised one ends kLiftAbove over the
// obstacle [m].
constexpr double kOverlap = 1e-4, kLiftAbove = 2e-4;
constexpr int kLiftRounds = 64;  // of clearing one obstacle after the other

/// Whether a box that is raised by `lift_m` overlaps another one.
bool overlaps(const Aabb& box, double lift_m, const Aabb& other) {
  return box.min.x() < other.max.x() && box.max.x() > other.min.x() &&
         box.min.y() < other.max.y() && box.max.y() > other.min.y() &&
         box.min.z() + lift_m < other.max.z() - kOverlap &&
         box.max.z() + lift_m > other.min.z() + kOverlap;
}

void place_at_rest(FreeBody& body, const Eigen::Isometry3d& X_WB) {
  body.place(X_WB, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
}

}  // namespace

BodyPlacement::BodyPlacement(PhysicsModel& model) : model_(model) {
  losing_.reserve(model.bodies.size());
}

void BodyPlacement::wake(int body) {
  auto& simplification = model_.simplification;
  if (simplification.dormant(body)) simplification.wake(simplification.sleeping().group(body));
}

void BodyPlacement::wake_all() {
  for (int i = 0; i < static_cast<int>(model_.bodies.size()); ++i) wake(i);
}

void BodyPlacement::set_velocity(int body, const Eigen::Vector3d& v_com_W,
                                 const Eigen::Vector3d& omega_W) {
  wake(body);
  model_.simplification.unmerge(body);
  // Before that its root moved it.
  FreeBody& free = model_.body(body);
  free.place(free.X_WB, v_com_W, omega_W);
}

void BodyPlacement::add_impulse(int body, const Eigen::Vector3d& impulse_W,
                                const Eigen::Vector3d& angular_W) {
  const FreeBody& free = model_.body(body);
  // v+ = v + J / m, omega+ = omega + R I^-1 R^T L.
  const Eigen::Matrix3d R_WB = free.X_WB.linear();
  const Eigen::Vector3d turn_B = free.mass.inertia.ldlt().solve(R_WB.transpose() * angular_W);
  set_velocity(body, free.v_com_W + impulse_W / free.mass.mass_kg, free.omega_W + R_WB * turn_B);
}

void BodyPlacement::set_decoupled_from_belt(int body, bool decoupled_from_belt) {
  if (model_.body(body).decoupled_from_belt == decoupled_from_belt) return;
  model_.body(body).decoupled_from_belt = decoupled_from_belt;
  // Its carrier changes.
  wake(body);
}

void BodyPlacement::place(std::span<const BodyPose> poses) {
  // Obstacles are compared by their present boxes, which sleeping bodies only have once awake.
  wake_all();
  std::vector<BodyPose> here;
  for (const BodyPose& pose : poses) {
    if (!model_.body(pose.body).lost_step) here.push_back(pose);
  }
  // Unmerge all of them before any of them moves.
  for (const BodyPose& pose : here) model_.simplification.remove_lost(pose.body);
  const auto place_raised = [&](BodyPose pose, double lift_m) {
    pose.X_WB.translation().z() += lift_m;
    place_at_rest(model_.body(pose.body), pose.X_WB);
  };
  for (const BodyPose& pose : here) place_raised(pose, 0);
  const double lift_m = clearance_m(here);
  for (const BodyPose& pose : here) place_raised(pose, lift_m);
}

void BodyPlacement::remove(int body, std::uint64_t step) {
  FreeBody& free = model_.body(body);
  if (free.lost_step) return;
  wake_all();
  // A removed body is placed where nothing can meet it. Its number stays, since bodies are numbered
  // for good.
  free.lost_step = step;
  model_.simplification.remove_lost(body);
  Eigen::Isometry3d X_WB = free.X_WB;
  X_WB.translation().z() = model_.lost_below_m - 1;
  place_at_rest(free, X_WB);
}

void BodyPlacement::lose_bodies(std::uint64_t step) {
  losing_.clear();
  for (const int i : model_.simplification.awake()) {
    const FreeBody& body = model_.body(i);
    const bool fallen = body.bounds.max.z() < model_.lost_below_m;
    if (fallen || has_diverged(body)) losing_.push_back(i);
  }
  for (const int i : losing_) {
    FreeBody& body = model_.body(i);
    // A pose that is not a number would spread to everything near it.
    Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
    X_WB.translation().z() = model_.lost_below_m - 1;
    if (!has_diverged(body)) X_WB = body.X_WB;
    body.lost_step = step;
    model_.simplification.remove_lost(i);
    place_at_rest(body, X_WB);
  }
}

/// Boxes of everything but the placed bodies.
std::vector<Aabb> BodyPlacement::obstacles(std::span<const BodyPose> placed) const {
  std::vector<Aabb> boxes;
  for (const StaticShape& shape : model_.fixed.shapes) boxes.push_back(shape.bounds);
  for (int i = 0; i < static_cast<int>(model_.bodies.size()); ++i) {
    const bool moved = std::ranges::find(placed, i, &BodyPose::body) != placed.end();
    if (!moved && !model_.body(i).lost_step) boxes.push_back(model_.body(i).bounds);
  }
  for (const auto& gripper : model_.grippers) boxes.push_back(gripper.parts().bounds());
  for (const auto& arm : model_.arms) {
    for (const auto& shape : arm.shapes()) boxes.push_back(shape.bounds);
  }
  return boxes;
}

/// Common height by which the bodies must be raised to be clear of all others.
double BodyPlacement::clearance_m(std::span<const BodyPose> placed) const {
  const std::vector<Aabb> others = obstacles(placed);
  double lift_m = 0;
  for (int round = 0; round < kLiftRounds; ++round) {
    const double before = lift_m;
    for (const BodyPose& pose : placed) {
      const Aabb& box = model_.body(pose.body).bounds;
      for (const Aabb& other : others) {
        // The lift only grows, so that the rounds end: each clears one obstacle for all bodies.
        if (overlaps(box, lift_m, other)) lift_m = other.max.z() + kLiftAbove - box.min.z();
      }
    }
    if (lift_m == before) break;
  }
  return lift_m;
}

}  // namespace aprsim::physics
