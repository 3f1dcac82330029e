#include "tests/benchmarks/pillars/pillar.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::bench {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kFriction = 2;    // nothing slides before it topples
constexpr double kWatched = 3;     // [s]
constexpr double kToppled = 0.03;  // of a body's axis from the normal of the slope [rad]
// Depths at which trays and gears rest upon each other [m]. From above them a pillar would fall.
constexpr double kTrayDepth = 1e-5, kGearDepth = 2e-6;

void add_bodies(scene::Scene& scene, const Pillar& pillar, const Isometry3d& X_WS) {
  scene::GearType disc;
  disc.name = "body";
  disc.disc_radius_m = pillar.radius_m;
  disc.disc_height_m = disc.peg_top_m = pillar.thickness_m;
  disc.mass_kg = pillar.mass_kg;
  scene::TrayType slab;
  slab.name = "body";
  slab.max_xy = {pillar.radius_m, 1.5 * pillar.radius_m};
  slab.min_xy = -slab.max_xy;
  slab.thickness_m = pillar.thickness_m;
  slab.mass_kg = pillar.mass_kg;
  scene.gear_types["body"] = disc;
  scene.tray_types["body"] = slab;
  for (int i = 0; i < pillar.count; ++i) {
    Isometry3d X = X_WS;
    // The frame of a slab is in its top face, that of a disc in its underside.
    const double height_m = (i + (pillar.slabs ? 1 : 0)) * pillar.thickness_m -
                            (i + 1) * (pillar.slabs ? kTrayDepth : kGearDepth);
    X.translation() += height_m * X_WS.linear().col(2);
    const std::string name = "body" + std::to_string(i);
    if (pillar.slabs) {
      scene.trays.push_back({.name = name, .type = "body", .X_WP = Pose::from(X)});
    } else {
      physics::test::add_gear(scene, name, "body", Pose::from(X));
    }
  }
}

}  // namespace

double Pillar::toppling_rad() const { return std::atan(2 * radius_m / (count * thickness_m)); }

Pillar random_pillar(std::mt19937_64& engine, bool slabs, int count) {
  std::uniform_real_distribution<double> unit(0, 1);
  const auto between = [&](double low, double high) { return low + (high - low) * unit(engine); };
  Pillar pillar;
  pillar.slabs = slabs;
  pillar.count = count;
  pillar.thickness_m = between(0.01, 0.03);
  pillar.radius_m = 0.5 * count * pillar.thickness_m * std::tan(between(0.1, 0.5));
  pillar.mass_kg = between(0.01, 0.2);
  pillar.heading_rad = between(0, 2 * std::numbers::pi);
  return pillar;
}

bool topples(const Pillar& pillar, double slope_rad) {
  Isometry3d X_WS = Isometry3d::Identity();
  X_WS.linear() = (Eigen::AngleAxisd(pillar.heading_rad, Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(slope_rad, Vector3d::UnitY()))
                      .toRotationMatrix();
  scene::Scene scene = physics::test::empty_scene();
  scene.physics.simplification = pillar.mode;
  scene.physics.step_s = pillar.step_s;
  auto& mu = scene.physics.friction;
  mu = {kFriction, kFriction, kFriction, kFriction, kFriction, kFriction, kFriction};
  Isometry3d X_WP = X_WS;
  X_WP.translation() -= 0.025 * X_WS.linear().col(2);
  scene.fixed.push_back({"slope", {1, 1, 0.05}, Pose::from(X_WP)});
  add_bodies(scene, pillar, X_WS);
  physics::test::Bench bench(std::move(scene));
  constexpr int kLooks = 30;
  for (int look = 0; look < kLooks; ++look) {
    bench.run(static_cast<int>(std::lround(kWatched / kLooks / pillar.step_s)));
    for (int i = 0; i < pillar.count; ++i) {
      const Vector3d axis = bench.world->body(i).q_WB * Vector3d::UnitZ();
      if (axis.dot(X_WS.linear().col(2)) < std::cos(kToppled)) return true;
    }
  }
  return false;
}

}  // namespace aprsim::bench
