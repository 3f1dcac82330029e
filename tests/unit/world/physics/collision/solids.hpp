#pragma once

#include <random>
#include <vector>

#include <Eigen/Geometry>

#include "world/physics/collision/pairs/narrow_phase.hpp"

/// Shapes of the tests and an oracle that knows them by sampling and by distances to profile
/// polygons, sharing no code with contact generation.
namespace aprsim::physics::test {

/// 2024 small gear: conical hub.
scene::GearType conical_gear();
/// Cylindrical hub r 10 x 6 mm with a 0.3 mm chamfer, disc r 30, peg r 3.8.
scene::GearType cylindrical_gear();

/// 160 x 160 x 15 mm, four conical recesses at (+-45, +-45).
scene::TrayType conical_tray();
/// 160 x 160 x 15 mm, four pockets r 10.3 with a 1 mm mouth chamfer at (+-45, +-45).
scene::TrayType cylindrical_tray();

/// The conical tray with a lopsided outline of seven corners.
scene::TrayType wedge_tray();
/// The tray's outline, its rectangle's corners if it has none.
std::vector<Eigen::Vector2d> corners_of(const scene::TrayType& tray);

/// Signed distance (negative inside) of a point to the solid, each in its own frame.
double gear_distance(const scene::GearType& gear, const Eigen::Vector3d& p);
double tray_distance(const scene::TrayType& tray, const Eigen::Vector3d& p);
double box_distance(const Eigen::Vector3d& half, const Eigen::Vector3d& p);
double prism_distance(const std::vector<Eigen::Vector2d>& corners, double z0, double z1,
                      const Eigen::Vector3d& p);

/// Points of the gear's surface, and dense ones of its circular edges.
std::vector<Eigen::Vector3d> gear_surface(const scene::GearType& gear, int around);
std::vector<Eigen::Vector3d> gear_rims(const scene::GearType& gear, int around);
/// Dense points of the other solids' edges.
std::vector<Eigen::Vector3d> tray_edges(const scene::TrayType& tray, int around);
std::vector<Eigen::Vector3d> box_edges(const Eigen::Vector3d& size, int along);

Eigen::Isometry3d pose(double x, double y, double z);
/// Tilted by `tilt` about the horizontal axis at `heading`, then at (x, y, z).
Eigen::Isometry3d tilted(double x, double y, double z, double tilt, double heading);
Eigen::Isometry3d random_rotation(std::mt19937_64& random);
double uniform(std::mt19937_64& random, double lo, double hi);

double deepest(const std::vector<Contact>& contacts);

}  // namespace aprsim::physics::test
