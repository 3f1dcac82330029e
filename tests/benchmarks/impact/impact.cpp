// Bodies that fall: how soon they rest, and whether contacts ever give energy. Bodies that fly at
// 10 m/s: how deep they go into what they meet.

#include <algorithm>
#include <numbers>
#include <vector>

#include "tests/benchmarks/impact/drops.hpp"
#include "tests/benchmarks/impact/strikes.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/modes.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/benchmarks/trays/tray_run.hpp"

namespace aprsim::bench {
namespace {

constexpr double kSlightTilt = 12 * std::numbers::pi / 180, kAnyTilt = 4;

scene::Scene bare_table(const Mode& mode) {
  scene::Scene scene = bare_belt(mode.value);
  scene.conveyor.reset();
  Pose below;
  below.p.z() = -0.025;
  scene.fixed.push_back({"table", {4, 4, 0.05}, below});
  return scene;
}

struct Worst {
  double rest_s = 0, gained_j = 0, total_j = 0, deepest_m = 0;
  std::uint64_t unsolved = 0;
  void add(const Drop& one) {
    rest_s = std::max(rest_s, one.rest_s);
    gained_j = std::max(gained_j, one.gained_j);
    total_j += one.gained_j;
    deepest_m = std::max(deepest_m, one.deepest_m);
    unsolved += one.unsolved;
  }
};

/// Every part and tray, from random poses: a few millimetres high and slightly tilted, or any way.
/// Returns the times of rest, the shortest first; `all` takes in the worst of them.
std::vector<double> tilted_drops(Experiment& experiment, const Mode& mode, Worst& all) {
  std::mt19937_64 engine(15);
  const int poses = experiment.quick() ? 2 : 200;
  const double seconds = experiment.quick() ? 3 : 10;
  Worst worst;
  std::vector<double> times;
  Table table({"body", "rests within [s]", "greatest gain [J]", "deepest [m]", "steps unsolved"});
  const scene::Scene bare = bare_table(mode);
  // `reach` is how far a body goes from its origin, `below` how far below it when slightly tilted.
  const auto run = [&](const std::string& type, bool tray, double reach, double below) {
    Worst own;
    for (int i = 0; i < poses; ++i) {
      const bool slight = i % 2 == 0;
      scene::Scene scene = bare;
      const Pose pose =
          random_pose(engine, 3e-3, slight ? below : reach, slight ? kSlightTilt : kAnyTilt);
      if (tray) {
        scene.trays.push_back({.name = "body", .type = type, .X_WP = pose});
      } else {
        scene.gears.push_back({.name = "body", .type = type, .X_WP = pose});
      }
      const Drop one = drop(std::move(scene), seconds);
      own.add(one);
      worst.add(one);
      times.push_back(one.rest_s);
    }
    table.row({type, own.rest_s, own.gained_j, own.deepest_m, static_cast<double>(own.unsolved)});
  };
  for (const auto& [name, type] : bare.gear_types) {
    run(name, false, std::hypot(type.disc_radius_m, std::max(type.peg_top_m, type.hub_height_m)),
        type.hub_height_m + type.disc_radius_m * std::sin(kSlightTilt));
  }
  for (const auto& [name, type] : bare.tray_types) {
    const double corner = std::max(type.min_xy.norm(), type.max_xy.norm());
    run(name, true, corner + type.thickness_m, type.thickness_m + corner * std::sin(kSlightTilt));
  }
  const std::string name = std::string("impact.") + mode.name;
  experiment.record(name + ".rest_s", worst.rest_s, "s");
  experiment.record(name + ".gained_j", worst.gained_j, "J");
  experiment.record(name + ".deepest_m", worst.deepest_m, "m");
  experiment.record(name + ".unsolved_steps", static_cast<double>(worst.unsolved), "count");
  experiment.table(std::string("drops_") + mode.name, "", table);
  all.rest_s = std::max(all.rest_s, worst.rest_s);
  all.gained_j = std::max(all.gained_j, worst.gained_j);
  std::sort(times.begin(), times.end());
  return times;
}

/// Every target, struck by parts at any attitude.
void strikes(Experiment& experiment) {
  const int throws = experiment.quick() ? 2 : 40;
  Table table({"mode", "target", "throws", "met", "passed", "deepest [mm]", "p90 [mm]"});
  double deepest = 0;
  int passed = 0;
  for (const auto& mode : kModes) {
    if (mode.value == scene::Simplification::kVirtualJoints) continue;
    if (experiment.quick() && mode.value != kDefaultMode.value) continue;
    for (const Target target : kTargets) {
      std::mt19937_64 engine(10);
      std::vector<double> depths;
      int met = 0, through = 0;
      for (const char* type : {"small", "medium", "d60"}) {
        for (int i = 0; i < throws; ++i) {
          const Strike one = strike(mode.value, target, type, engine);
          depths.push_back(1e3 * one.deepest_m);
          met += one.met;
          through += one.passed;
        }
      }
      const double most = percentile(depths, 1);
      table.row({mode.name, name_of(target), double(depths.size()), double(met), double(through),
                 most, percentile(depths, 0.9)});
      deepest = std::max(deepest, 1e-3 * most);
      passed += through;
    }
  }
  experiment.table("strikes", "Parts that strike at 10 m/s", table);
  experiment.record("impact.strike_deepest_m", deepest, "m");
  experiment.record("impact.strikes_passed", passed, "count");
}

int run(int argc, char** argv) {
  Experiment experiment("impact", argc, argv);
  strikes(experiment);
  Plot plot{.title = "Drops from random poses that have come to rest",
            .x = {.label = "time since release [s]"},
            .y = {.label = "share"}};
  Worst of_all;
  for (const auto& mode : kModes) {
    if (experiment.quick() && mode.value != kDefaultMode.value) continue;
    const std::vector<double> times = tilted_drops(experiment, mode, of_all);
    Series series{.name = mode.name};
    for (std::size_t i = 0; i < times.size(); ++i) {
      const auto rested = static_cast<double>(i + 1), all = static_cast<double>(times.size());
      series.points.emplace_back(times[i], rested / all);
    }
    plot.series.push_back(std::move(series));
  }
  experiment.plot("rest", plot);
  experiment.record("impact.drop_rest_s", of_all.rest_s, "s");
  experiment.record("impact.drop_gained_j", of_all.gained_j, "J");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
