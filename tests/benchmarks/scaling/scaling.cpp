// How the time of a step and the memory grow with the number of trays (four gears each) on the
// belt, awake (the belt's speed never stops changing) and at rest on the moving belt.

#include <cmath>
#include <fstream>
#include <malloc.h>
#include <stdexcept>
#include <unistd.h>

#include "tests/benchmarks/support/clock.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/modes.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/benchmarks/trays/tray_run.hpp"
#include "world/physics/physics_world.hpp"

namespace aprsim::bench {
namespace {

constexpr int kRows = 10;
constexpr double kPitch = 0.2;               // [m]
constexpr double kSpeed = 0.1, kRamp = 0.4;  // [m/s], [m/s2]
constexpr const char* kTrays[] = {"sku_medium_gear_vessel", "sku_small_gear_vessel"};

struct Timing {
  double awake_us = 0, swing_us = 0, rest_us = 0, observed_us = 0, heap_bytes = 0,
         resident_bytes = 0;
};

scene::Scene crowded(int trays, const Mode& mode) {
  scene::Scene scene = bare_belt(mode.value);
  const int columns = (trays + kRows - 1) / kRows;
  scene.conveyor->width_m = kPitch * kRows + 0.1;
  scene.conveyor->length_m = kPitch * columns + 4;
  const double z = scene.conveyor->X_WC.p.z();
  for (int i = 0; i < trays; ++i) {
    const auto& type = scene.tray_types.at(kTrays[(i + i / kRows) % 2]);
    scene::TrayInstance tray{.name = "tray_" + std::to_string(i), .type = type.name};
    const int column = i / kRows, row = i % kRows;
    tray.X_WP.p = {kPitch * column - 0.5 * kPitch * columns, kPitch * (row - 0.5 * (kRows - 1)),
                   z + type.thickness_m};
    for (const auto& slot : type.slots) {
      scene::GearInstance gear{.name = tray.name + "_" + slot.name, .type = slot.gear_type};
      gear.X_WP.p = tray.X_WP.p + Eigen::Vector3d(slot.xy.x(), slot.xy.y(), 0);
      tray.gears[slot.name] = gear.name;
      scene.gears.push_back(gear);
    }
    scene.trays.push_back(tray);
  }
  return scene;
}

double heap_in_use() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

/// Memory of the process that is in RAM: its second number in statm, in pages.
double resident() {
  std::ifstream statm("/proc/self/statm");
  double total = 0, pages = 0;
  if (!(statm >> total >> pages)) throw std::runtime_error("/proc/self/statm cannot be read");
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE));
}

/// Median time of a step over `steps` in parts of a tenth.
double time_steps(physics::PhysicsWorld& world, int steps, const auto& belt) {
  std::vector<double> parts;
  const int part = std::max(1, steps / 10);
  for (int done = 0; done < steps; done += part) {
    const double start = thread_cpu_s();
    for (int i = 0; i < part; ++i) {
      belt();
      world.step();
    }
    parts.push_back(1e6 * (thread_cpu_s() - start) / part);
  }
  return median(parts);
}

Timing measure(const scene::Scene& scene, bool can_rest) {
  Timing out;
  malloc_trim(0);  // what the last world has left must not hide what this one takes
  const double before = heap_in_use(), resident_before = resident();
  physics::PhysicsWorld world(scene, {}, {});
  const double h = scene.physics.step_s;
  const int trays = static_cast<int>(scene.trays.size());
  double speed = 0;
  int step = 0;
  const auto ramp = [&] {
    speed = std::min(kSpeed, speed + kRamp * h);
    world.set_belt_speed(speed);
  };
  const auto swing = [&] { world.set_belt_speed(speed + 0.02 * std::sin(0.01 * ++step)); };
  const auto steady = [&] { world.set_belt_speed(speed); };
  out.awake_us = time_steps(world, 10, ramp);
  // Without simplification it costs the same for ever: no need to wait for rest.
  const int few = std::max(10, std::min(300, 3000 / trays));
  for (int i = 0; i < (can_rest ? 300 : 40); ++i) {
    ramp();
    world.step();
  }
  out.swing_us = time_steps(world, few, swing);
  for (int i = 0; i < (can_rest ? 100 : 0); ++i) {
    steady();
    world.step();
  }
  const bool dormant = scene.physics.simplification == scene::Simplification::kDormant;
  out.rest_us = time_steps(world, dormant ? 1000 : few, steady);
  double sum = 0;
  out.observed_us = time_steps(world, few, [&] {
    steady();
    for (int i = 0; i < world.body_count(); ++i) sum += world.body(i).p_WB.x();
  });
  if (!std::isfinite(sum)) throw std::runtime_error("a body is nowhere");
  out.heap_bytes = heap_in_use() - before;
  out.resident_bytes = resident() - resident_before;
  return out;
}

int run(int argc, char** argv) {
  Experiment experiment("scaling", argc, argv);
  const std::vector<int> counts =
      experiment.quick() ? std::vector<int>{10, 30} : std::vector<int>{10, 30, 100, 300, 1000};
  Table table({"mode", "trays", "just spawned [us/step]", "belt swinging [us/step]",
               "at rest [us/step]", "at rest, all poses read [us/step]", "heap [MB]",
               "heap a tray [kB]", "RSS [MB]"});
  Plot plot{.title = "Time of a step over the number of trays, four gears each",
            .x = {.label = "trays", .log = true},
            .y = {.label = "us", .log = true}};
  // The shipped mode first: it is the one that is asked for.
  for (std::size_t i = kModes.size(); i-- > 0;) {
    const Mode& mode = kModes[i];
    const bool dormant = mode.value == scene::Simplification::kDormant;
    Series awake{std::string(mode.name) + ", spawned", {}};
    Series rest{std::string(mode.name) + ", at rest", {}};
    for (const int trays : counts) {
      const Timing timing =
          measure(crowded(trays, mode), mode.value != scene::Simplification::kOff);
      table.row({mode.name, static_cast<double>(trays), timing.awake_us, timing.swing_us,
                 timing.rest_us, timing.observed_us, 1e-6 * timing.heap_bytes,
                 1e-3 * timing.heap_bytes / trays, 1e-6 * timing.resident_bytes});
      awake.points.emplace_back(trays, timing.awake_us);
      rest.points.emplace_back(trays, timing.rest_us);
      const std::string count = std::to_string(trays);
      experiment.record("scaling." + std::string(mode.name) + ".awake_" + count + "_us",
                        timing.awake_us, "us");
      experiment.record("scaling." + std::string(mode.name) + ".rest_" + count + "_us",
                        timing.rest_us, "us");
      if (dormant) experiment.record("scaling.rest_" + count + "_us", timing.rest_us, "us");
      if (dormant) {
        experiment.record("scaling.rest_" + count + "_observed_us", timing.observed_us, "us");
      }
      if (dormant) experiment.record("scaling.heap_" + count + "_bytes", timing.heap_bytes, "B");
    }
    plot.series.push_back(awake);
    if (mode.value != scene::Simplification::kOff) plot.series.push_back(rest);
  }
  experiment.table("trays", "Time of a step and memory over the number of trays", table);
  experiment.plot("trays", plot);
  experiment.note(
      "Just spawned: the first ten steps, before anything is simplified. Swinging: the belt's "
      "speed "
      "changes all the time, by less than friction can carry. At rest: 0.1 s after it has "
      "become steady. Poses of resting bodies are computed on demand, so a second figure has "
      "all of them read after every step, as a snapshot does.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
