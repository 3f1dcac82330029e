#include "tests/benchmarks/pick/pick_case.hpp"

#include <algorithm>
#include <cmath>

#include "tests/benchmarks/support/clock.hpp"

namespace aprsim::bench {
namespace {

using physics::test::Bench;

constexpr double kLift = 0.05, kPlaceHeight = 1e-4;
constexpr double kMaxPlaced = 1e-3;  // farther from its slot a gear is not in it

double pitch_of(const std::string& gear) {
  return gear == "d100" || gear == "large" ? 0.055 : 0.045;
}

scene::Scene scene_of(const PickCase& c) {
  using namespace physics::test;
  scene::Scene scene = empty_scene();
  scene.physics.step_s = c.step_s;
  auto& mu = scene.physics.friction;
  mu.gear_tray = mu.gear_gear = mu.gear_ground = mu.tray_ground = mu.tray_belt = mu.tray_tray =
      mu.robot = c.mu;
  scene.gear_types[c.gear] = gear_type(c.gear);
  const double pitch = pitch_of(c.gear);
  scene::TrayType type = tray_type(c.gear, 2 * pitch, pitch);
  if (c.gear[0] == 'd') {  // those with a cylindrical hub of 10 mm
    for (auto& slot : type.slots) {
      const double wider = c.pocket_clearance_m + 0.01 - slot.pocket.top_radius_m;
      slot.pocket.top_radius_m += wider;
      slot.pocket.floor_radius_m += wider;
      slot.pocket.chamfer_m = c.pocket_chamfer_m;
    }
  }
  scene.tray_types[type.name] = type;
  add_table(scene);
  add_tray(scene, "a", type.name, {0, 0}, {"s1=g", "s2=n2", "s3=n3", "s4=n4"});
  add_tray(scene, "b", type.name, {5 * pitch, 0}, {"s2=m2", "s3=m3", "s4=m4"});
  const Eigen::Vector2d at = Eigen::Vector2d(-pitch, pitch) + Eigen::Rotation2Dd(c.yaw) * c.off;
  const double tip =
      type.thickness_m + scene.gear_types.at(c.gear).disc_height_m + c.tip_over_disc_m;
  auto& gripper = add_hand(scene, {at.x(), at.y(), tip + kLift}, c.yaw).gripper;
  gripper.law = c.law;
  gripper.pad = c.pad;
  gripper.pad_friction = c.mu;
  gripper.palm_stiffness_n_m = c.palm_stiffness_n_m;
  gripper.finger_speed_m_s = c.finger_speed_m_s;
  return scene;
}

struct Run {
  const PickCase& c;
  Bench bench;
  PickResult result;
  std::vector<double> start_z;
  bool closing = false;

  explicit Run(const PickCase& the_case) : c(the_case), bench(scene_of(the_case)) {}

  [[nodiscard]] double z(const char* name) const { return bench.X_WB(name).translation().z(); }

  void observe() {
    auto& world = *bench.world;
    result.penetration_m = std::max(result.penetration_m, world.max_penetration_m());
    result.deflection_m = std::max(result.deflection_m, world.gripper(0).palm_deflection_m);
    if (!closing) return;
    result.pop_m = std::max(result.pop_m, z("g") - start_z[0]);
    result.hop_m = std::max(result.hop_m, z("a") - start_z[1]);
  }

  void step(const Eigen::Isometry3d* X_WT) {
    const bool merged = bench.world->gripper(0).force_n[0] > 0 && in_tray();
    const double before = 1e6 * thread_cpu_s();
    X_WT ? bench.step_tool(*X_WT) : bench.run(1);
    if (merged) result.merged_us.push_back(1e6 * thread_cpu_s() - before);
    observe();
  }

  [[nodiscard]] bool in_tray() const {
    const double pitch = pitch_of(c.gear);
    const Eigen::Vector3d p = bench.X_WB("g").translation();
    return p.z() < 0.015 + 1e-4 || (p.x() > 3 * pitch && p.z() < 0.015 + 7e-3);
  }

  void rest(double seconds) {
    const auto count = std::lround(seconds / c.step_s);
    for (long i = 0; i < count; ++i) step(nullptr);
  }

  void move(const Eigen::Vector3d& delta, double seconds) {
    const Eigen::Isometry3d start = bench.X_WT;
    const auto count = std::lround(seconds / c.step_s);
    for (long i = 1; i <= count; ++i) {
      const double s = static_cast<double>(i) / static_cast<double>(count);
      Eigen::Isometry3d next = start;
      next.translation() += s * s * s * (10 - 15 * s + 6 * s * s) * delta;
      step(&next);
    }
  }

  void grip(double setting) {
    bench.world->set_gripper(0, setting);
    const double limit = bench.steps + 0.5 / c.step_s;
    do {
      step(nullptr);
    } while (bench.steps < limit && !bench.world->gripper(0).settled);
    rest(0.05);
  }

  void pick() {
    rest(0.12);
    move({0, 0, -kLift}, 0.15);
    start_z = {0.015, 0.015};
    std::vector<double> neighbours;
    for (const char* name : {"n2", "n3", "n4"}) neighbours.push_back(z(name));
    closing = true;
    grip(0);
    closing = false;
    const Eigen::Isometry3d X_closed = bench.X_TB("g");
    result.centring_m = X_closed.translation().head<2>().norm();
    move({0, 0, kLift}, 0.4);
    const auto hand = bench.world->gripper(0);
    result.picked = hand.holding && hand.held_body == bench.index_of("g") && z("g") > 0.06;
    const double pitch = pitch_of(c.gear);
    const Eigen::Vector3d way =
        bench.X_WB("b") * Eigen::Vector3d(-pitch, pitch, 0) - bench.X_WB("g").translation();
    move({way.x() + c.place_off.x(), way.y() + c.place_off.y(), 0}, 0.4);
    const Eigen::Isometry3d X_carried = bench.X_TB("g");
    result.slip_m = (X_carried.translation() - X_closed.translation()).norm();
    result.slip_rad = physics::test::angle_between(X_closed, X_carried);
  }

  void place() {
    const double pitch = pitch_of(c.gear);
    const Eigen::Vector3d slot(-pitch, pitch, 0);
    const double down = z("g") - (bench.X_WB("b") * slot).z() - kPlaceHeight;
    move({0, 0, -down}, 0.5);
    rest(0.05);
    grip(1);
    move({0, 0, kLift}, 0.15);
    rest(0.1);
    const Eigen::Isometry3d X_BG = bench.X_WB("b").inverse() * bench.X_WB("g");
    const Eigen::Vector3d error = X_BG.translation() - slot;
    result.place_error_m = error.head<2>().norm();
    result.tilt_rad = std::acos(std::clamp(X_BG.linear()(2, 2), -1.0, 1.0));
    result.penetration_faults = bench.world->penetration_faults();
    result.placed =
        error.norm() < kMaxPlaced && result.tilt_rad < 0.02 && result.penetration_faults == 0;
  }
};

}  // namespace

PickResult run_pick(const PickCase& the_case) {
  Run run(the_case);
  run.pick();
  if (run.result.picked) run.place();
  return run.result;
}

}  // namespace aprsim::bench
