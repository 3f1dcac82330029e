#include "tests/benchmarks/impact/strikes.hpp"

#include <algorithm>

#include "tests/benchmarks/impact/drops.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::bench {
namespace {

using namespace physics::test;
using Eigen::Vector3d;

constexpr double kSpeed = 10, kAway = 0.15, kOff = 5e-3, kMostSpin = 10;  // [m/s], [m], [rad/s]
constexpr double kAnyAttitude = 4, kThin = 5e-3, kSunk = 1e-3;
constexpr int kSettle = 60, kSteps = 100;
constexpr double kPadTip = 0.3;  // height of the hand that is struck [m]

/// The target's middle and the direction from which it is struck.
struct Aim {
  Vector3d at = Vector3d::Zero(), from = Vector3d::UnitZ();
};

Aim add_target(scene::Scene& scene, Target target) {
  switch (target) {
    case Target::kPlate: {
      Pose pose;
      pose.p.z() = -0.5 * kThin;
      scene.fixed.push_back({"plate", {2, 2, kThin}, pose});
      return {};
    }
    case Target::kTable:
      add_table(scene);
      return {};
    case Target::kBelt:
      add_belt(scene);
      return {};
    case Target::kTray:
      add_table(scene);
      add_tray(scene, "tray", "medium4", {0, 0}, {});
      return {};
    case Target::kFullTray:
      add_table(scene);
      add_tray(scene, "tray", "medium4", {0, 0}, {"s1=a", "s2=b", "s3=c", "s4=d"});
      return {};
    case Target::kPad:
      add_table(scene);
      add_hand(scene, {0, 0, kPadTip});
      // The open fingers from outside, across their thickness.
      return {{0, 0, kPadTip + 0.5 * scene.robots[0].gripper.pad_height_m}, Vector3d::UnitY()};
    case Target::kPart: {
      add_table(scene);
      Pose pose;
      pose.p.z() = scene.gear_types.at("large").hub_height_m;
      add_gear(scene, "lying", "large", pose);
      return {};
    }
  }
  return {};
}

}  // namespace

const char* name_of(Target target) {
  switch (target) {
    case Target::kPlate:
      return "plate of 5 mm";
    case Target::kTable:
      return "table";
    case Target::kBelt:
      return "belt";
    case Target::kTray:
      return "tray";
    case Target::kFullTray:
      return "full tray";
    case Target::kPad:
      return "fingers";
    case Target::kPart:
      return "part";
  }
  return "";
}

Strike strike(scene::Simplification mode, Target target, const std::string& type,
              std::mt19937_64& engine) {
  std::uniform_real_distribution<double> unit(-1, 1);
  scene::Scene scene = empty_scene();
  scene.physics.simplification = mode;
  const Aim aim = add_target(scene, target);
  const bool level = aim.from.z() == 0;
  Pose pose = random_pose(engine, 0, 0, kAnyAttitude);
  const double x = unit(engine), y = unit(engine), ahead = unit(engine);
  const Vector3d across = level ? Vector3d(x, 0, y) : Vector3d(x, y, 0);
  // Anywhere within a step's way.
  pose.p = aim.at + (kAway + 0.5 * kSpeed * 1e-3 * ahead) * aim.from + kOff * across;
  const double g = scene.physics.gravity_m_s2, fall_s = kSettle * scene.physics.step_s;
  pose.p.z() += 0.5 * g * fall_s * fall_s;
  add_gear(scene, "thrown", type, pose);
  Bench bench(std::move(scene));
  bench.run(kSettle);
  const int thrown = bench.index_of("thrown");
  const double a = unit(engine), b = unit(engine), c = unit(engine);
  bench.world->set_velocity(thrown, -kSpeed * aim.from, kMostSpin * Vector3d(a, b, c));
  Strike result;
  for (int step = 0; step < kSteps; ++step) {
    bench.run(1);
    result.deepest_m = std::max(result.deepest_m, bench.world->max_penetration_m());
    const auto state = bench.world->body(thrown);
    const double beyond = -(state.p_WB - aim.at).dot(aim.from);
    if (-state.v_W.dot(aim.from) < 0.9 * kSpeed) result.met = true;
    if (!result.met && beyond > 0.5 * kAway) result.passed = true;
    const bool over = state.p_WB.head<2>().cwiseAbs().maxCoeff() < 0.25;
    if (!level && over && state.p_WB.z() < -kSunk) result.passed = true;
  }
  return result;
}

}  // namespace aprsim::bench
