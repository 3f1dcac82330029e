#pragma once

#include <Eigen/Geometry>

#include "world/scene/model/scene.hpp"

namespace aprsim::physics {

struct MassProperties {
  double mass_kg = 0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero();      ///< in the body's own frame [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the com, body axes [kg m2]

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [mass_kg, com, inertia] = self;
    io(mass_kg, com, inertia);
  }
};

/// Disc, hub (with chamfer) and peg of uniform density that add up to the type's mass.
[[nodiscard]] MassProperties gear_mass(const scene::GearType& gear);

/// Slab less its pockets (with mouth chamfers), of uniform density, with the type's mass.
[[nodiscard]] MassProperties tray_mass(const scene::TrayType& tray);

/// All of a tool as one box where the palm is, in the tool frame.
[[nodiscard]] MassProperties tool_mass(const scene::Gripper& gripper);

/// Moment of inertia of a uniform box about its centre, along its edges.
[[nodiscard]] Eigen::Matrix3d box_inertia(double mass_kg, const Eigen::Vector3d& size_m);

/// Both as one rigid body, in the first's frame: `X_AB` is the second's frame in the first's.
[[nodiscard]] MassProperties combined(const MassProperties& a, const MassProperties& b,
                                      const Eigen::Isometry3d& X_AB);

}  // namespace aprsim::physics
