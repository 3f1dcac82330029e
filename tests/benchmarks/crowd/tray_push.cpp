#include "tests/benchmarks/crowd/tray_push.hpp"

#include <algorithm>
#include <cmath>

#include "tests/benchmarks/support/clock.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"
#include "world/physics/bodies/physics_failure.hpp"

namespace aprsim::bench {
namespace {

using Eigen::Vector3d;
using physics::test::Bench;

constexpr double kGap = 2e-3, kTipHeight = 3e-3;  // of the fingers from the tray and the table [m]
constexpr double kPushWay = 0.25,
                 kPushTime = 1;  // of the push: 1.875 kPushWay / kPushTime = 0.47 m/s at most

scene::Scene scene_of(const PushCase& c) {
  scene::Scene scene = physics::test::empty_scene();
  scene.physics.simplification = c.mode;
  physics::test::add_table(scene);
  scene::TrayType& tray = scene.tray_types.at("small4");
  for (std::size_t i = 0; i < 2; ++i) {
    scene::GearType type = scene.gear_types.at("small");
    type.name = "heavy" + std::to_string(i);
    type.mass_kg = c.part_kg[i];
    scene.gear_types[type.name] = type;
  }
  // Slots 1 and 3 are at the pushed side.
  for (std::size_t i = 0; i < 4; ++i) tray.slots[i].gear_type = i % 2 == 0 ? "heavy0" : "heavy1";
  physics::test::add_tray(scene, "tray", "small4", {0, 0}, {"s1=p1", "s2=p2", "s3=p3", "s4=p4"},
                          c.heading_rad);
  // The fingers' narrow sides ahead: tool x, turned with the heading.
  auto& gripper = physics::test::add_hand(scene, Vector3d::Zero(), c.heading_rad).gripper;
  const double back = -tray.min_xy.x() + 0.5 * gripper.pad_width_m + kGap;
  const Vector3d along(std::cos(c.heading_rad), std::sin(c.heading_rad), 0);
  scene.robots[0].X_WB.p += -back * along + Vector3d(0, 0, kTipHeight);
  return scene;
}

/// Counts what happens in a step; the fingers' speed from where they were.
void observe(const Bench& bench, Vector3d& tip, double step_s, PushResult& result) {
  const auto& world = *bench.world;
  const Vector3d now = world.gripper(0).X_WT.p;
  result.pusher_m_s = std::max(result.pusher_m_s, (now - tip).norm() / step_s);
  tip = now;
  for (const char* part : {"p1", "p2", "p3", "p4"}) {
    const auto state = world.body(bench.index_of(part));
    result.part_m_s = std::max(result.part_m_s, state.v_W.norm());
  }
  result.deepest_m = std::max(result.deepest_m, world.max_penetration_m());
}

void run(Bench& bench, const PushCase& c, PushResult& result) {
  const double h = bench.scene.physics.step_s;
  const Vector3d along(std::cos(c.heading_rad), std::sin(c.heading_rad), 0);
  bench.run(100);
  bench.grip(0);
  const Eigen::Isometry3d start = bench.X_WT;
  const auto unsolved = bench.world->solver_failures().not_converged;
  Vector3d tip = bench.world->gripper(0).X_WT.p;
  const int moving = static_cast<int>(std::lround(kPushTime / h)), all = moving + 300;
  double before_m = 0;
  for (int i = 1; i <= all; ++i) {
    const double s = std::min(1.0, double(i) / moving);
    const double way_m = s * s * s * (10 - 15 * s + 6 * s * s) * kPushWay;
    result.hand_m_s = std::max(result.hand_m_s, (way_m - before_m) / h);
    before_m = way_m;
    Eigen::Isometry3d next = start;
    next.translation() += way_m * along;
    const double before = 1e6 * thread_cpu_s();
    bench.step_tool(next);
    const double us = 1e6 * thread_cpu_s() - before;
    result.step_us += us / all;
    result.longest_us = std::max(result.longest_us, us);
    observe(bench, tip, h, result);
  }
  result.unsolved = bench.world->solver_failures().not_converged - unsolved;
  const double tray_z = bench.X_WB("tray").translation().z();
  for (const char* part : {"p1", "p2", "p3", "p4"}) {
    if (std::abs(bench.X_WB(part).translation().z() - tray_z) > 1e-3) result.faults = true;
  }
}

}  // namespace

PushResult push_tray(const PushCase& c) {
  Bench bench(scene_of(c));
  PushResult result;
  try {
    run(bench, c, result);
  } catch (const physics::PhysicsFailure&) {
    result.faults = true;
  }
  return result;
}

}  // namespace aprsim::bench
