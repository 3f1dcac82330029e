#include "tests/benchmarks/pillars/coaxial_drop.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/benchmarks/support/modes.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::bench {
namespace {

using Eigen::Vector3d;

constexpr int kSteps = 500;

}  // namespace

CoaxialDrop coaxial_drop(std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto between = [&](double low, double high) { return low + (high - low) * unit(engine); };
  const auto random_disc = [&](const char* name) {
    scene::GearType type;
    type.name = name;
    type.disc_radius_m = between(0.008, 0.05);
    type.disc_height_m = type.peg_top_m = between(0.002, 0.02);
    type.mass_kg = between(0.005, 0.2);
    return type;
  };
  scene::Scene scene = physics::test::empty_scene();
  scene.physics.simplification =
      kModes[static_cast<std::size_t>(unit(engine) * kModes.size())].value;
  const double e = unit(engine) < 0.5 ? 0 : between(0, 0.5);
  scene.physics.restitution = {e, e, e, e, e, e, e};
  physics::test::add_table(scene);
  CoaxialDrop out;
  out.equal = unit(engine) < 0.5;
  const scene::GearType lower = random_disc("lower");
  scene::GearType upper = out.equal ? lower : random_disc("upper");
  upper.name = "upper";
  if (!out.equal && unit(engine) < 0.5) {  // on a hub with a face of its own
    upper.hub_top_radius_m = upper.hub_bottom_radius_m = between(0.3, 0.9) * upper.disc_radius_m;
    upper.hub_height_m = between(0.002, 0.01);
  }
  scene.gear_types["lower"] = lower;
  scene.gear_types["upper"] = upper;
  const auto small = [&](double least) {
    return unit(engine) < 0.2 ? 0 : least * std::pow(1e-3 / least, unit(engine));
  };
  out.off_axis_m = small(1e-12);
  out.tilt_rad = small(1e-9);
  out.height_m = unit(engine) < 0.3 ? 0 : between(0, 5e-3);
  physics::test::add_gear(scene, "lower", "lower", {});
  const double heading = between(0, 2 * std::numbers::pi), about = between(0, 2 * std::numbers::pi);
  Pose pose;
  const double rest = lower.disc_height_m + upper.hub_height_m;
  pose.p = {out.off_axis_m * std::cos(heading), out.off_axis_m * std::sin(heading),
            rest + out.height_m};
  pose.q = Eigen::AngleAxisd(out.tilt_rad, Vector3d(std::cos(about), std::sin(about), 0));
  physics::test::add_gear(scene, "upper", "upper", pose);
  physics::test::Bench bench(std::move(scene));
  for (int step = 0; step < kSteps; ++step) {
    bench.run(1);
    out.deepest_m = std::max(out.deepest_m, bench.world->max_penetration_m());
  }
  out.sunk_m = rest - (bench.X_WB("lower").inverse() * bench.X_WB("upper")).translation().z();
  return out;
}

}  // namespace aprsim::bench
