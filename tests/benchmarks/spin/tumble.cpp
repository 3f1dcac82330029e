#include "tests/benchmarks/spin/tumble.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/benchmarks/impact/drops.hpp"
#include "tests/benchmarks/support/clock.hpp"
#include "tests/benchmarks/trays/tray_run.hpp"

namespace aprsim::bench {
namespace {

constexpr double kAnyTilt = 4, kReach = 0.15, kPitch = 0.3;  // [rad], [m]
constexpr double kMostSpin = 6;                              // about each axis [rad/s]

}  // namespace

scene::Scene tumbling_trays(scene::Simplification mode, unsigned seed) {
  std::mt19937_64 engine(seed);
  scene::Scene scene = shipped_scene("table1");
  scene.conveyor.reset();
  scene.fixed.clear();
  scene.floor = false;
  scene.physics.simplification = mode;
  Pose below;
  below.p.z() = -0.025;
  scene.fixed.push_back({"table", {8, 8, 0.05}, below});
  for (std::size_t t = 0; t < scene.trays.size(); ++t) {
    auto& tray = scene.trays[t];
    const Eigen::Isometry3d X_PW = tray.X_WP.isometry().inverse();
    tray.X_WP = random_pose(engine, 0.1, kReach, kAnyTilt);
    const auto row = t / 5, column = t % 5;
    tray.X_WP.p += kPitch * Eigen::Vector3d(double(column), double(row), 0);
    for (auto& gear : scene.gears) {
      for (const auto& [slot, name] : tray.gears) {
        if (name != gear.name) continue;
        gear.X_WP = Pose::from(tray.X_WP.isometry() * X_PW * gear.X_WP.isometry());
      }
    }
  }
  return scene;
}

namespace {

/// Every tray with its gears as one body.
void spin(physics::PhysicsWorld& world, const scene::Scene& scene, unsigned seed) {
  std::mt19937_64 engine(seed + 1);
  std::uniform_real_distribution<double> unit(-kMostSpin, kMostSpin);
  const int trays = static_cast<int>(scene.trays.size());
  for (int t = 0; t < trays; ++t) {
    const auto& tray = scene.trays[static_cast<std::size_t>(t)];
    const double x = unit(engine), y = unit(engine), z = unit(engine);
    const Eigen::Vector3d omega(x, y, z);
    const auto strike = [&](int body, const Eigen::Vector3d& com_B) {
      const auto state = world.body(body);
      const Eigen::Vector3d lever = state.p_WB + state.q_WB * com_B - tray.X_WP.p;
      world.set_velocity(body, omega.cross(lever), omega);
    };
    strike(t, physics::tray_mass(scene.tray_types.at(tray.type)).com);
    for (std::size_t g = 0; g < scene.gears.size(); ++g) {
      for (const auto& [slot, name] : tray.gears) {
        if (name != scene.gears[g].name) continue;
        const auto& type = scene.gear_types.at(scene.gears[g].type);
        strike(trays + static_cast<int>(g), physics::gear_mass(type).com);
      }
    }
  }
}

}  // namespace

Tumble tumble(scene::Simplification mode, unsigned seed, double seconds) {
  const scene::Scene scene = tumbling_trays(mode, seed);
  Falling falling(scene);
  auto& world = falling.world();
  spin(world, scene, seed);
  Tumble out;
  const double at_first = falling.energy_j();
  double before = at_first;
  bool struck = false;
  const int steps = static_cast<int>(std::lround(seconds / scene.physics.step_s));
  for (int step = 0; step < steps; ++step) {
    const double start = 1e6 * thread_cpu_s();
    world.step();
    out.step_us.push_back(1e6 * thread_cpu_s() - start);
    out.deepest_m = std::max(out.deepest_m, world.max_penetration_m());
    const double energy = falling.energy_j();
    if (struck) out.gained_j += std::max(0.0, energy - before);
    before = energy;
    // Gears touch their trays from the first step on: the table tells.
    struck = struck || step * scene.physics.step_s > 0.1;
  }
  out.energy_j = at_first - before;
  out.unsolved = world.solver_failures().not_converged;
  return out;
}

}  // namespace aprsim::bench
