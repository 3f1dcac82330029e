#pragma once

#include <algorithm>
#include <array>

#include <Eigen/Geometry>

#include "world/scene/model/parts.hpp"
#include "world/scene/model/robot.hpp"
#include "world/scene/model/tool.hpp"

/// The primitives that gears, trays and grippers consist of, each in the frame of what it is part
/// of. Contacts, sensors, descriptions and the check of a scene have their shapes from here.
namespace aprsim::scene {

/// A frustum about z.
struct Frustum {
  double z_low = 0, z_high = 0;
  double radius_low = 0, radius_high = 0;
};

struct GearShapes {
  Frustum disc, peg;  ///< cylinders
  Frustum hub;        ///< without the chamfer of its lower rim
};
[[nodiscard]] inline GearShapes shapes_of(const GearType& type) {
  return {.disc = {0, type.disc_height_m, type.disc_radius_m, type.disc_radius_m},
          .peg = {type.disc_height_m, type.peg_top_m, type.peg_radius_m, type.peg_radius_m},
          .hub = {-type.hub_height_m, 0, type.hub_bottom_radius_m, type.hub_top_radius_m}};
}

/// The slab without its pockets; where it has an outline, the box around it.
[[nodiscard]] inline Eigen::AlignedBox3d slab_of(const TrayType& type) {
  return {Eigen::Vector3d(type.min_xy.x(), type.min_xy.y(), -type.thickness_m),
          Eigen::Vector3d(type.max_xy.x(), type.max_xy.y(), 0)};
}

/// A box along the axes of its frame.
struct Block {
  Eigen::Vector3d centre, size;
};

/// The palm behind the pads, in the tool frame.
[[nodiscard]] inline Block palm_of(const Gripper& gripper) {
  return {{0, 0, -gripper.pad_height_m - 0.5 * gripper.palm_size.z()}, gripper.palm_size};
}

/// The fingers at an opening of `separation_m` from pad to pad, in the tool frame: the one at +y,
/// then the one at -y.
[[nodiscard]] inline std::array<Block, 2> fingers_of(const Gripper& gripper, double separation_m) {
  const Eigen::Vector3d size(gripper.pad_width_m, gripper.pad_depth_m, gripper.pad_height_m);
  const double y = 0.5 * (separation_m + gripper.pad_depth_m), z = -0.5 * gripper.pad_height_m;
  return {{{{0, y, z}, size}, {{0, -y, z}, size}}};
}

/// Around the cup of a tool that has one, in the tool frame.
[[nodiscard]] inline Block cup_of(const Gripper& gripper) {
  const double width = 2 * gripper.cup.value_or(VacuumCup{}).radius_m;
  return {{0, 0, -0.5 * gripper.pad_height_m}, {width, width, gripper.pad_height_m}};
}

/// The cup as a solid of revolution: its disc from the lip at z = 0 up, against the approach.
[[nodiscard]] inline GearType cup_solid(const Gripper& gripper) {
  GearType solid;
  solid.name = "cup";
  solid.disc_radius_m = gripper.cup.value_or(VacuumCup{}).radius_m;
  solid.disc_height_m = gripper.pad_height_m;
  return solid;
}

/// From the coupling to the face of the palm towards the part, along the approach.
[[nodiscard]] inline double seat_of(const Tool& tool) {
  return tool.X_QT.p.z() - tool.gripper.pad_height_m;
}

/// Between palm and coupling, in the tool frame; without volume where the palm reaches the
/// coupling.
[[nodiscard]] inline Block neck_of(const Tool& tool) {
  constexpr double kShare = 0.7;       // of the palm's lesser width
  constexpr double kClearance = 2e-3;  // of the coupling's faces
  const Eigen::Vector3d& palm = tool.gripper.palm_size;
  const double palm_top = tool.gripper.pad_height_m + palm.z();
  const double length = std::max(0.0, tool.X_QT.p.z() - kClearance - palm_top);
  const double width = kShare * palm.head<2>().minCoeff();
  return {{0, 0, -palm_top - 0.5 * length}, {width, width, length}};
}

}  // namespace aprsim::scene
