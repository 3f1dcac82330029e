// Trays that stand on a table while closed fingers hold their edge: pad forces, force sensor and
// what the gripper reports.

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/in_parallel.hpp"
#include "tests/benchmarks/support/modes.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::bench {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr int kWatched = 1000;  // steps
constexpr double kGravity = 9.81;
constexpr std::array kSteps = {2e-3, 1e-3, 5e-4, 2.5e-4};

/// One grip. SI.
struct Grip {
  Eigen::Vector2d half{0.08, 0.08};
  double thickness_m = 0.015, mass_kg = 0.2;
  double depth_m = 0.012;       ///< of the finger tips beyond the edge
  double along_m = 0, yaw = 0;  ///< place along the edge, tray against hand
  double height_m = 0;          ///< of the hand over the middle of the edge
  double force_n = 60;
  scene::PadShape pad = scene::PadShape::kFlat;
  scene::Simplification mode = scene::Simplification::kDormant;
  double step_s = 1e-3;
};

Grip random_grip(std::mt19937_64& engine) {
  std::uniform_real_distribution<double> unit(0, 1);
  const auto between = [&](double low, double high) { return low + (high - low) * unit(engine); };
  Grip grip;
  grip.half = {between(0.075, 0.12), between(0.075, 0.12)};
  grip.thickness_m = between(0.008, 0.018);
  grip.mass_kg = between(0.1, 0.6);
  grip.depth_m = between(0.004, 0.02);
  grip.along_m = between(-0.03, 0.03);
  grip.yaw = between(-0.2, 0.2);
  grip.height_m = between(-1e-3, 1e-3);
  grip.force_n = between(20, 100);
  grip.pad = unit(engine) < 0.5 ? scene::PadShape::kFlat : scene::PadShape::kV;
  grip.mode = kModes[static_cast<std::size_t>(unit(engine) * kModes.size())].value;
  grip.step_s = kSteps[static_cast<std::size_t>(unit(engine) * kSteps.size())];
  return grip;
}

scene::Scene scene_of(const Grip& grip) {
  scene::Scene scene = physics::test::empty_scene();
  scene.physics.simplification = grip.mode;
  scene.physics.step_s = grip.step_s;
  scene::TrayType type;
  type.name = "slab";
  type.min_xy = -grip.half;
  type.max_xy = grip.half;
  type.thickness_m = grip.thickness_m;
  type.mass_kg = grip.mass_kg;
  scene.tray_types["slab"] = type;
  Pose below;
  below.p.z() = -0.025;
  scene.fixed.push_back({"table", {0.08, 0.08, 0.05}, below});
  physics::test::add_tray(scene, "tray", "slab", {0, 0}, {}, grip.yaw);
  scene::Robot& robot = physics::test::add_hand(scene, Vector3d::Zero());
  robot.gripper.pad = grip.pad;
  robot.gripper.force_n = grip.force_n;
  Isometry3d X_WT = Isometry3d::Identity();
  X_WT.linear().col(2) = Vector3d::UnitX();
  X_WT.linear().col(1) = Vector3d::UnitZ();
  X_WT.linear().col(0) = Vector3d::UnitZ().cross(Vector3d::UnitX());
  const Vector3d edge =
      Eigen::AngleAxisd(grip.yaw, Vector3d::UnitZ()) * Vector3d(-grip.half.x(), grip.along_m, 0);
  X_WT.translation() = edge + Vector3d(grip.depth_m, 0, 0.5 * grip.thickness_m + grip.height_m);
  robot.X_WB = Pose::from(X_WT * robot.X_FT.isometry().inverse());
  return scene;
}

/// Readings over the watched steps.
struct Readings {
  double pad_n = 0;             ///< mean of both pads
  double pad_deviation = 0;     ///< greatest, of a pad from its own mean, over that mean
  double sensor_deviation = 0;  ///< of the vertical force on the hand, over the tray's weight
  double fastest_m_s = 0;       ///< of the tray
  int not_holding = 0, unsettled = 0;  ///< steps
};

double deviation(const std::vector<double>& samples) {
  const double middle = mean(samples);
  double most = 0;
  for (const double sample : samples) most = std::max(most, std::abs(sample - middle));
  return most;
}

Readings readings_of(const Grip& grip) {
  physics::test::Bench bench(scene_of(grip));
  const auto rest = [&](double seconds) {
    bench.run(static_cast<int>(std::lround(seconds / grip.step_s)));
  };
  rest(0.2);
  bench.world->set_gripper(0, 0);
  rest(1.0);
  Readings out;
  std::array<std::vector<double>, 2> pads;
  std::vector<double> sensor;
  for (int step = 0; step < kWatched; ++step) {
    bench.run(1);
    const auto hand = bench.world->gripper(0);
    for (std::size_t i = 0; i < 2; ++i) pads[i].push_back(hand.force_n[i]);
    double up = 0;
    for (const auto& force : bench.world->arm_forces(0)) up += force.relayed ? 0 : force.f_W.z();
    sensor.push_back(up);
    out.fastest_m_s = std::max(out.fastest_m_s, bench.world->body(0).v_W.norm());
    out.not_holding += hand.holding ? 0 : 1;
    out.unsettled += hand.settled ? 0 : 1;
  }
  for (const auto& pad : pads) {
    out.pad_n += 0.5 * mean(pad);
    out.pad_deviation = std::max(out.pad_deviation, deviation(pad) / std::max(1e-3, mean(pad)));
  }
  out.sensor_deviation = deviation(sensor) / (grip.mass_kg * kGravity);
  return out;
}

const char* name_of(scene::Simplification mode) {
  for (const Mode& one : kModes) {
    if (one.value == mode) return one.name;
  }
  return "";
}

int run(int argc, char** argv) {
  Experiment experiment("tray_grip", argc, argv);
  std::mt19937_64 engine(45);
  std::vector<Grip> grips(experiment.quick() ? 8 : 400);
  for (Grip& grip : grips) grip = random_grip(engine);
  const auto all = in_parallel(grips.size(), [&](std::size_t i) { return readings_of(grips[i]); });
  Table table({"mode", "step [ms]", "pads", "force set [N]", "tray [kg]", "thickness [mm]",
               "depth [mm]", "along [mm]", "yaw [rad]", "height [mm]", "pad force, mean [N]",
               "pad deviation", "sensor deviation", "fastest [m/s]", "steps not holding",
               "steps unsettled"});
  std::vector<double> pads, sensors;
  int unsteady = 0, not_holding = 0, unsettled = 0;
  for (std::size_t i = 0; i < grips.size(); ++i) {
    const Grip& grip = grips[i];
    const Readings& one = all[i];
    table.row({name_of(grip.mode), 1e3 * grip.step_s,
               grip.pad == scene::PadShape::kV ? "V" : "flat", grip.force_n, grip.mass_kg,
               1e3 * grip.thickness_m, 1e3 * grip.depth_m, 1e3 * grip.along_m, grip.yaw,
               1e3 * grip.height_m, one.pad_n, one.pad_deviation, one.sensor_deviation,
               one.fastest_m_s, double(one.not_holding), double(one.unsettled)});
    pads.push_back(one.pad_deviation);
    sensors.push_back(one.sensor_deviation);
    unsteady += one.pad_deviation > 0.01 || one.sensor_deviation > 0.01 ? 1 : 0;
    not_holding += one.not_holding;
    unsettled += one.unsettled;
  }
  experiment.table("grips", "", table);
  Table shares({"reading", "median", "p90", "p99", "greatest"});
  const auto row = [&](const char* name, const std::vector<double>& samples) {
    shares.row({name, percentile(samples, 0.5), percentile(samples, 0.9), percentile(samples, 0.99),
                percentile(samples, 1)});
  };
  row("pad force, deviation from its mean", pads);
  row("vertical sensor force, deviation from its mean, over the weight", sensors);
  experiment.table("deviations", "Trays on a table between closed fingers", shares);
  experiment.record("tray_grip.pad_force_deviation", percentile(pads, 1), "relative");
  experiment.record("tray_grip.sensor_deviation", percentile(sensors, 1), "relative");
  experiment.record("tray_grip.unsteady_grips", unsteady, "count");
  experiment.record("tray_grip.steps_not_holding", not_holding, "count");
  experiment.record("tray_grip.steps_unsettled", unsettled, "count");
  experiment.note(
      "Random slabs of 15 to 24 cm and 8 to 18 mm, 0.1 to 0.6 kg, stand on a table. Fingers of 20 "
      "to 100 N, flat or V, hold 4 to 20 mm of an edge, up to 30 mm off its middle. The hand is "
      "yawed "
      "by up to 0.2 rad and up to 1 mm off the edge's height. All modes, steps of 0.25 to 2 ms. "
      "Readings of 1000 steps from 1 s after the command to close on.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
