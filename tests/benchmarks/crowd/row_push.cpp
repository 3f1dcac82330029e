#include "tests/benchmarks/crowd/row_push.hpp"

#include <algorithm>
#include <cmath>

#include "tests/benchmarks/support/clock.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::bench {
namespace {

using Eigen::Vector3d;
using physics::test::Bench;

constexpr const char* kType = "d60";
constexpr double kApart = 2e-4, kAhead = 0.02;  // between gears of the row, and before it [m]
constexpr double kWay = 0.15, kRamp = 0.05;     // of the push [m], to its speed and back [s]
constexpr double kAboveDisc = 3.5e-3;

scene::Scene scene_of(const RowCase& c) {
  scene::Scene scene = physics::test::empty_scene();
  scene.physics.simplification = c.mode;
  physics::test::add_table(scene);
  const scene::GearType& type = scene.gear_types.at(kType);
  std::mt19937_64 engine(c.seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  const Vector3d along(std::cos(c.heading_rad), std::sin(c.heading_rad), 0);
  const Vector3d across(-along.y(), along.x(), 0);
  const double pitch = 2 * type.disc_radius_m + kApart;
  for (int i = 0; i <= c.gears; ++i) {
    Pose pose;
    pose.p.z() = type.hub_height_m;
    // Those that stand off the row's line do not reach so far along it.
    if (i > 0) pose.p += (kAhead + pitch * i) * along + c.scatter_m * unit(engine) * across;
    physics::test::add_gear(scene, "g" + std::to_string(i), kType, pose);
  }
  const double tip = type.hub_height_m + type.disc_height_m + kAboveDisc;
  physics::test::add_hand(scene, {0, 0, tip}, c.hand_yaw_rad);
  return scene;
}

/// Force of the contacts between the held gear and others.
double load_on(const Bench& bench, int held, std::vector<api::ContactSnapshot>& contacts) {
  using Kind = api::ContactSide::Kind;
  bench.world->write_contacts(contacts);
  Vector3d f = Vector3d::Zero();
  for (const auto& contact : contacts) {
    const bool first = contact.first.kind == Kind::kBody && contact.first.index == held;
    const bool second = contact.second.kind == Kind::kBody && contact.second.index == held;
    const bool robot = contact.first.kind == Kind::kRobot || contact.second.kind == Kind::kRobot;
    if ((first || second) && !robot) f += (first ? 1 : -1) * contact.f_W;
  }
  return f.norm();
}

/// Ramps from rest to `speed` and back, over the way; where it is after a step.
std::vector<double> profile(double speed, double step_s) {
  std::vector<double> out;
  double v = 0, s = 0;
  const double a = speed / kRamp;
  while (v > 0 || s == 0) {
    const bool brakes = kWay - s <= 0.5 * v * v / a + v * step_s;
    v = std::clamp(brakes ? v - a * step_s : v + a * step_s, 0.0, speed);
    s += v * step_s;
    out.push_back(s);
  }
  return out;
}

}  // namespace

RowResult push_row(const RowCase& c) {
  Bench bench(scene_of(c));
  bench.run(100);
  bench.grip(0);
  bench.move({0, 0, 5e-4}, 0.1);  // off the table
  bench.run(50);
  const int held = bench.index_of("g0");
  const Eigen::Isometry3d X_TG = bench.X_TB("g0"), start = bench.X_WT;
  const Vector3d along(std::cos(c.heading_rad), std::sin(c.heading_rad), 0);
  const auto unsolved = bench.world->solver_failures().not_converged;
  RowResult result{.held = bench.world->gripper(0).holding};
  std::vector<api::ContactSnapshot> contacts;
  int steps = 0;
  for (const double s : profile(c.speed_m_s, bench.scene.physics.step_s)) {
    Eigen::Isometry3d next = start;
    next.translation() += s * along;
    const double before = 1e6 * thread_cpu_s();
    bench.step_tool(next);
    const double us = 1e6 * thread_cpu_s() - before;
    result.step_us += us;
    result.longest_us = std::max(result.longest_us, us);
    ++steps;
    const Eigen::Isometry3d now = bench.X_TB("g0");
    const double slip = (now.translation() - X_TG.translation()).norm();
    result.slip_m = std::max(result.slip_m, slip);
    result.slip_rad = std::max(result.slip_rad, physics::test::angle_between(X_TG, now));
    result.deepest_m = std::max(result.deepest_m, bench.world->max_penetration_m());
    result.load_n = std::max(result.load_n, load_on(bench, held, contacts));
    result.held = result.held && bench.world->gripper(0).holding;
  }
  result.step_us /= steps;
  result.unsolved = bench.world->solver_failures().not_converged - unsolved;
  return result;
}

}  // namespace aprsim::bench
