#include "tests/benchmarks/friction/chutes.hpp"

#include <numbers>

#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::bench {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;
using physics::test::Bench;

constexpr double kPlate = 0.05, kSettled = 0.6, kTime = 0.3;
constexpr double kOnset = 5e-6;  // more than this is a slip [m]

/// At tan(inclination) = share * mu.
scene::Scene scene_of(const ChuteCase& c, double share) {
  scene::Scene scene = physics::test::empty_scene();
  scene.physics.simplification = c.mode;
  scene.physics.step_s = kStep;
  scene.physics.friction.tray_ground = scene.physics.friction.gear_ground = c.friction;
  const double incline = std::atan(share * c.friction);
  const Eigen::Quaterniond plate(AngleAxisd(c.heading_rad, Vector3d::UnitZ()) *
                                 AngleAxisd(incline, Vector3d::UnitY()));
  scene.fixed.push_back({"plate", {4, 4, kPlate}, {plate * Vector3d(0, 0, -0.5 * kPlate), plate}});
  const Eigen::Quaterniond q = plate * AngleAxisd(c.yaw_rad, Vector3d::UnitZ());
  if (c.gear) {
    const double height = scene.gear_types.at("large").hub_height_m;
    physics::test::add_gear(scene, "slider", "large", {plate * Vector3d(0, 0, height), q});
  } else {
    const double height = scene.tray_types.at("small4").thickness_m;
    physics::test::add_tray(scene, "slider", "small4", {0, 0}, {});
    scene.trays.back().X_WP = {plate * Vector3d(0, 0, height), q};
  }
  return scene;
}

/// How far it slides downhill in some time from its first rest on. Adds up unsolved steps.
double slip(const ChuteCase& c, double share, double seconds, std::uint64_t& unsolved) {
  Bench bench(scene_of(c, share));
  const Vector3d downhill = bench.scene.fixed.back().X_WS.q * Vector3d::UnitX();
  bench.run(static_cast<int>(std::lround(kSettled / kStep)));
  const Vector3d start = bench.X_WB("slider").translation();
  bench.run(static_cast<int>(std::lround(seconds / kStep)));
  unsolved += bench.world->solver_failures().not_converged;
  return downhill.dot(bench.X_WB("slider").translation() - start);
}

/// Distance by the closed form, from the start on.
double closed_form(const ChuteCase& c, double share, double seconds) {
  constexpr double kGravity = 9.81;
  const double incline = std::atan(share * c.friction), t0 = kSettled, t1 = kSettled + seconds;
  const double a = kGravity * (std::sin(incline) - c.friction * std::cos(incline));
  return 0.5 * a * (t1 * t1 - t0 * t0);
}

}  // namespace

Verdict chute(const ChuteCase& c, int halvings) {
  Verdict verdict;
  const auto slid = [&](double share) { return slip(c, share, kTime, verdict.unsolved); };
  verdict.creep_m_s = std::abs(slid(kCreepShare)) / kTime;
  verdict.false_drop = std::abs(slid(kBelowShare)) > kNoSlip;
  verdict.false_hold = slid(kAboveShare) < 0.5 * closed_form(c, kAboveShare, kTime);
  double held = 0.9, slips = 1.1;
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (held + slips);
    (slid(middle) > kOnset ? slips : held) = middle;
  }
  verdict.onset = 0.5 * (held + slips);
  return verdict;
}

ChuteCase random_chute(std::mt19937_64& engine, bool gear) {
  std::uniform_real_distribution<double> unit(0, 1);
  constexpr double kTurn = 2 * std::numbers::pi;
  ChuteCase out{.gear = gear};
  out.heading_rad = kTurn * unit(engine);
  out.yaw_rad = kTurn * unit(engine);
  out.friction = 0.1 + 0.7 * unit(engine);
  return out;
}

}  // namespace aprsim::bench
