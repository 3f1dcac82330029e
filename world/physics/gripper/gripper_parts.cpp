#include "world/physics/gripper/gripper_parts.hpp"

#include "world/physics/bodies/tool_shape.hpp"
#include "world/scene/model/part_shapes.hpp"

namespace aprsim::physics {
namespace {

/// Bounds that meet nothing.
const Aabb kNowhere{Eigen::Vector3d::Constant(1e30), Eigen::Vector3d::Constant(-1e30)};

}  // namespace

GripperParts::GripperParts(const scene::Gripper& gripper, const Eigen::Isometry3d& X_WT)
    : pad_(pad_of(gripper)), has_cup_(gripper.cup.has_value()) {
  const auto set = [this](std::size_t i, const scene::Block& block) {
    parts_[i].size = block.size;
    parts_[i].X_TS.translation() = block.centre;
  };
  set(0, scene::palm_of(gripper));
  const auto fingers = scene::fingers_of(gripper, gripper.gap_open_m);
  for (std::size_t i = 0; i < 2; ++i) set(i + 1, fingers[i]);
  if (has_cup_) {
    set(1, scene::cup_of(gripper));
    cup_solid_ = scene::cup_solid(gripper);
  }
  // The lever is internal to the linkage. It never collides, and its size only gives it inertia.
  const double travel = 0.5 * (gripper.gap_open_m - gripper.gap_closed_m);
  parts_[kLever].size = Eigen::Vector3d(4 * travel, 0.25 * travel, 0.25 * travel);
  parts_[kLever].X_TS.translation().z() = -0.5 * gripper.pad_height_m;
  for (GripperPart& part : parts_) {
    part.X_WS = X_WT * part.X_TS;
    part.bounds = aabb_of_box(part.size, part.X_WS);
  }
}

Eigen::Isometry3d GripperParts::X_WD(int finger) const {
  const GripperPart& box = part(finger + 1);
  return box.X_WS * pad_in_finger(finger, box.size);
}

Eigen::Vector3d GripperParts::closing_W(int finger) const {
  return (finger == 0 ? -1.0 : 1.0) * part(finger + 1).X_WS.linear().col(1);
}

void GripperParts::follow(const Eigen::Isometry3d& X_WT, const std::array<double, 2>& travel_m) {
  follow_removed(X_WT, travel_m);
  for (std::size_t i = 0; i < std::size_t{has_cup_ ? 2u : 3u}; ++i) {
    parts_[i].bounds = aabb_of_box(parts_[i].size, parts_[i].X_WS);
  }
}

void GripperParts::follow_removed(const Eigen::Isometry3d& X_WT,
                                  const std::array<double, 2>& travel_m) {
  for (std::size_t i = 0; i < kColliding; ++i) {
    Eigen::Isometry3d X_TS = parts_[i].X_TS;
    // Fingers close along -y and +y of the tool frame.
    if (i == 1) X_TS.translation().y() -= travel_m[0];
    if (i == 2) X_TS.translation().y() += travel_m[1];
    parts_[i].X_WS = X_WT * X_TS;
    parts_[i].bounds = kNowhere;
  }
}

void GripperParts::place(std::size_t part, const Eigen::Matrix3d& R_WS,
                         const Eigen::Vector3d& p_WS) {
  GripperPart& box = parts_[part];
  box.X_WS.linear() = R_WS;
  box.X_WS.translation() = p_WS;
  box.bounds = aabb_of_box(box.size, box.X_WS);
}

void GripperParts::place_cup() {
  GripperPart& cup = parts_[1];
  cup.X_WS = X_WT() * cup.X_TS;
  cup.bounds = aabb_of_box(cup.size, cup.X_WS);
}

void GripperParts::hold_lever(const Eigen::Isometry3d& X_WT) {
  parts_[kLever].X_TS = X_WT.inverse() * parts_[kLever].X_WS;
}

void GripperParts::place_lever(const Eigen::Isometry3d& X_WT) {
  parts_[kLever].X_WS = X_WT * parts_[kLever].X_TS;
}

}  // namespace aprsim::physics
