#include "tests/benchmarks/rotation/free_spin.hpp"

#include <algorithm>
#include <cmath>

#include "world/physics/bodies/mass_properties.hpp"
#include "world/physics/physics_world.hpp"

namespace aprsim::bench {
namespace {

using Eigen::Vector3d;

scene::TrayType random_slab(std::mt19937_64& engine) {
  std::uniform_real_distribution<double> half(0.02, 0.15), thickness(0.005, 0.05), kg(0.05, 1);
  scene::TrayType type;
  type.name = "slab";
  type.max_xy = {half(engine), half(engine)};
  type.min_xy = -type.max_xy;
  type.thickness_m = thickness(engine);
  type.mass_kg = kg(engine);
  return type;
}

scene::GearType random_gear(std::mt19937_64& engine) {
  std::uniform_real_distribution<double> unit(0, 1);
  scene::GearType type;
  type.name = "gear";
  type.disc_radius_m = 0.02 + 0.05 * unit(engine);
  type.disc_height_m = 0.004 + 0.02 * unit(engine);
  type.hub_top_radius_m = type.hub_bottom_radius_m = 0.5 * type.disc_radius_m;
  type.hub_height_m = 0.002 + 0.02 * unit(engine);
  type.peg_radius_m = 0.004;
  type.peg_top_m = type.disc_height_m + 0.05 * unit(engine);
  type.mass_kg = 0.01 + 0.1 * unit(engine);
  return type;
}

/// Energy and angular momentum of the rotation.
struct Rotation {
  double energy_j = 0;
  Vector3d angular_momentum = Vector3d::Zero();
};

Rotation rotation_of(const physics::BodyState& body, const Eigen::Matrix3d& inertia_B) {
  const Eigen::Matrix3d R = body.q_WB.normalized().toRotationMatrix();
  Rotation out;
  out.angular_momentum = R * (inertia_B * (R.transpose() * body.omega_W));
  out.energy_j = 0.5 * body.omega_W.dot(out.angular_momentum);
  return out;
}

}  // namespace

FreeSpin random_free_spin(std::mt19937_64& engine, double max_rad_s) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> rate(1, max_rad_s), unit(0, 1);
  FreeSpin out;
  out.scene.name = "free";
  out.scene.floor = false;
  out.scene.physics.gravity_m_s2 = 0;
  Pose pose;
  const double w = normal(engine), x = normal(engine), y = normal(engine);
  pose.q = Eigen::Quaterniond(w, x, y, normal(engine)).normalized();
  if (unit(engine) < 0.6) {
    out.scene.tray_types["slab"] = random_slab(engine);
    out.scene.trays.push_back({.name = "body", .type = "slab", .X_WP = pose});
  } else {
    out.scene.gear_types["gear"] = random_gear(engine);
    out.scene.gears.push_back({.name = "body", .type = "gear", .X_WP = pose});
  }
  const double a = normal(engine), b = normal(engine);
  out.omega_W = rate(engine) * Vector3d(a, b, normal(engine)).normalized();
  return out;
}

SpinErrors errors_of(const FreeSpin& spin, double seconds) {
  const physics::MassProperties mass = spin.scene.trays.empty()
                                           ? physics::gear_mass(spin.scene.gear_types.at("gear"))
                                           : physics::tray_mass(spin.scene.tray_types.at("slab"));
  physics::PhysicsWorld world(spin.scene, {}, {});
  world.set_velocity(0, Vector3d::Zero(), spin.omega_W);
  const Rotation start = rotation_of(world.body(0), mass.inertia);
  const auto a_second = std::lround(1 / spin.scene.physics.step_s);
  SpinErrors out;
  for (long step = 1; step <= std::lround(seconds) * a_second; ++step) {
    world.step();
    if (step % a_second != 0) continue;
    const Rotation now = rotation_of(world.body(0), mass.inertia);
    out.energy = std::max(out.energy, std::abs(now.energy_j / start.energy_j - 1));
    out.angular_momentum =
        std::max(out.angular_momentum, (now.angular_momentum - start.angular_momentum).norm() /
                                           start.angular_momentum.norm());
  }
  return out;
}

}  // namespace aprsim::bench
