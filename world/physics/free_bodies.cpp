#include "world/physics/free_bodies.hpp"

#include <algorithm>
#include <cmath>

#include "world/physics/mass_properties.hpp"

namespace aprsim::physics {
namespace {

/// A solid of revolution about z, between two heights, is bounded along each world axis by its
/// half length and the projection of its rim.
Bounds bounds_of_gear(const scene::GearType& gear, const Eigen::Isometry3d& X_WG) {
  const double low = -gear.hub_height_m;
  const double high = std::max(gear.disc_height_m, gear.peg_top_m);
  const Eigen::Vector3d centre = X_WG * Eigen::Vector3d(0, 0, 0.5 * (low + high));
  const double radius = std::max(gear.disc_radius_m, gear.hub_top_radius_m);
  Eigen::Vector3d reach;
  for (int axis = 0; axis < 3; ++axis) {
    const double c = X_WG.linear()(axis, 2);
    reach[axis] = 0.5 * (high - low) * std::abs(c) + radius * std::sqrt(std::max(0.0, 1 - c * c));
  }
  return {centre - reach, centre + reach};
}

double gear_radius(const scene::GearType& gear, const Eigen::Vector3d& com) {
  const double disc =
      std::hypot(gear.disc_radius_m, std::max(std::abs(com.z()), gear.disc_height_m - com.z()));
  const double peg = std::hypot(gear.peg_radius_m, gear.peg_top_m - com.z());
  const double hub = std::hypot(gear.hub_top_radius_m, com.z() + gear.hub_height_m);
  return std::max({disc, peg, hub});
}

void give_mass(FreeBody& free, const MassProperties& mass) {
  free.mass_kg = mass.mass_kg;
  free.com_B = mass.com;
  const dMass ode_mass = ode::mass(mass.mass_kg, mass.inertia);
  dBodySetMass(free.body.get(), &ode_mass);
}

FreeBody make_tray(const scene::TrayInstance& instance, const scene::TrayType& type,
                   dWorldID world) {
  FreeBody free;
  free.name = instance.name;
  free.tray = &type;
  free.body.reset(dBodyCreate(world));
  give_mass(free, tray_mass(type));
  const Eigen::Vector2d extent = type.max_xy - type.min_xy;
  const Eigen::Vector2d middle = 0.5 * (type.max_xy + type.min_xy);
  free.slab_size = {extent.x(), extent.y(), type.thickness_m};
  free.X_BS.translation() = Eigen::Vector3d(middle.x(), middle.y(), -0.5 * type.thickness_m);
  free.radius_m = 0.5 * free.slab_size.norm() + (free.com_B - free.X_BS.translation()).norm();
  free.place(instance.X_WP.isometry(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  return free;
}

FreeBody make_gear(const scene::GearInstance& instance, const scene::GearType& type,
                   dWorldID world) {
  FreeBody free;
  free.name = instance.name;
  free.gear = &type;
  free.body.reset(dBodyCreate(world));
  give_mass(free, gear_mass(type));
  free.radius_m = gear_radius(type, free.com_B);
  free.place(instance.X_WP.isometry(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  return free;
}

Bounds bounds_of(const FreeBody& free) {
  return free.is_tray() ? bounds_of_box(free.slab_size, free.X_WS())
                        : bounds_of_gear(*free.gear, free.X_WB);
}

}  // namespace

Bounds bounds_of_box(const Eigen::Vector3d& size, const Eigen::Isometry3d& X_WS) {
  const Eigen::Vector3d reach = X_WS.linear().cwiseAbs() * (0.5 * size);
  return {X_WS.translation() - reach, X_WS.translation() + reach};
}

void FreeBody::refresh() {
  X_WB.linear() = ode::matrix(dBodyGetRotation(body.get()));
  const Eigen::Vector3d com = ode::vector(dBodyGetPosition(body.get()));
  X_WB.translation() = com - X_WB.linear() * com_B;
  v_com_W = ode::vector(dBodyGetLinearVel(body.get()));
  omega_W = ode::vector(dBodyGetAngularVel(body.get()));
  bounds = bounds_of(*this);
}

void FreeBody::place(const Eigen::Isometry3d& X_WB_new, const Eigen::Vector3d& v_com,
                     const Eigen::Vector3d& omega) {
  ode::set_rotation(body.get(), X_WB_new.linear());
  ode::set_position(body.get(), X_WB_new * com_B);
  ode::set_velocity(body.get(), v_com, omega);
  refresh();
}

std::vector<FreeBody> make_free_bodies(const scene::Scene& scene, dWorldID world) {
  std::vector<FreeBody> bodies;
  bodies.reserve(scene.trays.size() + scene.gears.size());
  for (const auto& tray : scene.trays) {
    bodies.push_back(make_tray(tray, scene.tray_types.at(tray.type), world));
  }
  for (const auto& gear : scene.gears) {
    bodies.push_back(make_gear(gear, scene.gear_types.at(gear.type), world));
  }
  return bodies;
}

}  // namespace aprsim::physics
