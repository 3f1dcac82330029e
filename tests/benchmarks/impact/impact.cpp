// Bodies that fall: how soon they rest, and whether contacts ever give energy. Bodies that fly at
// 10 m/s: how deep they go into what they meet.

#include <algorithm>
#include <array>
#include <numbers>
#include <vector>

#include "tests/benchmarks/impact/drops.hpp"
#include "tests/benchmarks/impact/strikes.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/in_parallel.hpp"
#include "tests/benchmarks/support/modes.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/benchmarks/trays/tray_run.hpp"

namespace aprsim::bench {
namespace {

constexpr double kSlightTilt = 12 * std::numbers::pi / 180, kAnyTilt = 4;
constexpr double kClearance = 3e-3;                        // [m]
constexpr double kLongest = 10, kRested = 1, kLong = 600;  // [s]
// Algorithms 1-2 of the paper join gears to trays: a body on its own is as in mode `off`.
constexpr std::array kDropped = {kModes[0], kModes[2], kModes[3]};

scene::Scene bare_table(const Mode& mode) {
  scene::Scene scene = bare_belt(mode.value);
  scene.conveyor.reset();
  Pose below;
  below.p.z() = -0.025;
  scene.fixed.push_back({"table", {4, 4, 0.05}, below});
  return scene;
}

struct Worst {
  double rest_s = 0, gained_j = 0, risen_j = 0, deepest_m = 0;
  std::uint64_t unsolved = 0;
  std::vector<double> rests_s;  // of all
  void add(const Drop& one) {
    rest_s = std::max(rest_s, one.rest_s);
    gained_j = std::max(gained_j, one.gained_j);
    risen_j = std::max(risen_j, one.risen_j);
    deepest_m = std::max(deepest_m, one.deepest_m);
    unsolved += one.unsolved;
    rests_s.push_back(one.rest_s);
  }
};

/// A falling part or tray: its reach from the origin, and below the origin upright or upside down.
struct Faller {
  std::string type;
  bool tray = false;
  double reach = 0, below = 0, above = 0;
};

std::vector<Faller> fallers(const scene::Scene& scene) {
  std::vector<Faller> out;
  for (const auto& [name, type] : scene.gear_types) {
    const double top = std::max({type.peg_top_m, type.hub_height_m, type.disc_height_m});
    out.push_back({name, false, std::hypot(type.disc_radius_m, top), type.hub_height_m, top});
  }
  for (const auto& [name, type] : scene.tray_types) {
    const double corner = std::max(type.min_xy.norm(), type.max_xy.norm());
    out.push_back({name, true, corner + type.thickness_m, type.thickness_m, type.thickness_m});
  }
  for (Faller& one : out) {
    const double lower = one.reach * std::sin(kSlightTilt);
    one.below += lower;
    one.above += lower;
  }
  return out;
}

/// Every second pose: a few millimetres high and slightly tilted, on either face in turns; the
/// others: any way.
std::vector<Pose> poses_of(const Faller& faller, int count, std::mt19937_64& engine) {
  std::vector<Pose> out;
  for (int i = 0; i < count; ++i) {
    if (i % 2 == 1) {
      out.push_back(random_pose(engine, kClearance, faller.reach, kAnyTilt));
    } else if (i % 4 == 0) {
      out.push_back(random_pose(engine, kClearance, faller.below, kSlightTilt));
    } else {
      out.push_back(upside_down(random_pose(engine, kClearance, faller.above, kSlightTilt)));
    }
  }
  return out;
}

scene::Scene falling(const scene::Scene& table, const Faller& faller, const Pose& pose) {
  scene::Scene scene = table;
  if (faller.tray) {
    scene.trays.push_back({.name = "body", .type = faller.type, .X_WP = pose});
  } else {
    scene.gears.push_back({.name = "body", .type = faller.type, .X_WP = pose});
  }
  return scene;
}

/// Every part and tray, from random poses, the same in all modes.
class Drops {
 public:
  explicit Drops(Experiment& experiment) : experiment_(experiment) {}

  void run() {
    for (const Mode& mode : kDropped) {
      if (experiment_.quick() && mode.value != kDefaultMode.value) continue;
      drop_all(mode);
      let_lie(mode);
    }
    experiment_.table("drops", "Drops from random poses, worst of each body", table_);
    experiment_.plot("rest", plot_);
    experiment_.record("impact.drop_rest_s", worst_.rest_s, "s");
    experiment_.record("impact.drop_gained_j", worst_.gained_j, "J");
    experiment_.record("impact.drop_deepest_m", worst_.deepest_m, "m");
    experiment_.record("impact.ten_minutes.rest_s", lying_.rest_s, "s");
    experiment_.record("impact.ten_minutes.gained_j", lying_.gained_j, "J");
    experiment_.record("impact.ten_minutes.risen_j", lying_.risen_j, "J");
    experiment_.record("impact.drop_unsolved_steps", double(worst_.unsolved), "count");
  }

 private:
  void drop_all(const Mode& mode) {
    std::mt19937_64 engine(15);
    const scene::Scene table = bare_table(mode);
    Worst of_mode;
    for (const Faller& faller : fallers(table)) {
      const auto poses = poses_of(faller, experiment_.quick() ? 2 : 200, engine);
      const auto drops = in_parallel(poses.size(), [&](std::size_t i) {
        return drop(falling(table, faller, poses[i]), experiment_.quick() ? 3 : kLongest, kRested);
      });
      Worst own;
      for (const Drop& one : drops) {
        own.add(one);
        of_mode.add(one);
        worst_.add(one);
      }
      table_.row({mode.name, faller.type, double(drops.size()), own.rest_s, own.risen_j,
                  own.gained_j, 1e3 * own.deepest_m, double(own.unsolved)});
    }
    const std::string name = std::string("impact.") + mode.name;
    experiment_.record(name + ".rest_s", of_mode.rest_s, "s");
    experiment_.record(name + ".gained_j", of_mode.gained_j, "J");
    experiment_.record(name + ".deepest_m", of_mode.deepest_m, "m");
    experiment_.record(name + ".unsolved_steps", double(of_mode.unsolved), "count");
    Series series{.name = mode.name};
    std::sort(of_mode.rests_s.begin(), of_mode.rests_s.end());
    const auto all = static_cast<double>(of_mode.rests_s.size());
    for (std::size_t i = 0; i < of_mode.rests_s.size(); ++i) {
      series.points.emplace_back(of_mode.rests_s[i], double(i + 1) / all);
    }
    plot_.series.push_back(std::move(series));
  }
  /// Two of each, on either face, for ten minutes.
  void let_lie(const Mode& mode) {
    std::mt19937_64 engine(16);
    const scene::Scene table = bare_table(mode);
    std::vector<scene::Scene> scenes;
    for (const Faller& one : fallers(table)) {
      const auto poses = poses_of(one, 3, engine);
      scenes.push_back(falling(table, one, poses[0]));
      scenes.push_back(falling(table, one, poses[2]));
    }
    const double seconds = experiment_.quick() ? 3 : kLong;
    const auto drops = in_parallel(
        scenes.size(), [&](std::size_t i) { return drop(scenes[i], seconds, seconds); });
    Worst own;
    for (const Drop& one : drops) {
      own.add(one);
      lying_.add(one);
    }
    table_.row({mode.name, "each on both faces, ten minutes", double(drops.size()), own.rest_s,
                own.risen_j, own.gained_j, 1e3 * own.deepest_m, double(own.unsolved)});
  }

  Experiment& experiment_;
  Worst worst_, lying_;
  Table table_{{"mode", "body", "drops", "rests within [s]", "greatest rise [J]",
                "gains added up [J]", "deepest [mm]", "unsolved steps"}};
  Plot plot_{.title = "Drops from random poses that have come to rest",
             .x = {.label = "time since release [s]"},
             .y = {.label = "share"},
             .series = {}};
};

/// Every target, struck by parts at any attitude.
void strikes(Experiment& experiment) {
  constexpr std::array kTypes = {"small", "medium", "d60"};
  // Rare events show in many throws; modes hardly differ.
  Table table({"mode", "target", "throws", "met", "passed", "deepest [mm]", "p99 [mm]", "p90 [mm]",
               "over 0.5 mm"});
  constexpr double kTooDeep = 0.5;  // [mm]
  double deepest = 0;
  int passed = 0, struck = 0, too_deep = 0;
  for (const auto& mode : kDropped) {
    if (experiment.quick() && mode.value != kDefaultMode.value) continue;
    const std::size_t most_throws = mode.value == kDropped.front().value ? 300 : 40;
    const std::size_t throws = experiment.quick() ? 2 : most_throws;
    for (const Target target : kTargets) {
      const auto all = in_parallel(kTypes.size() * throws, [&](std::size_t i) {
        std::mt19937_64 engine(1000 * (1 + std::size_t(target)) + i);
        return strike(mode.value, target, kTypes[i / throws], engine);
      });
      std::vector<double> depths;
      int met = 0, through = 0, deep = 0;
      for (const Strike& one : all) {
        depths.push_back(1e3 * one.deepest_m);
        deep += depths.back() > kTooDeep;
        met += one.met;
        through += one.passed;
      }
      const double most = percentile(depths, 1);
      table.row({mode.name, name_of(target), double(depths.size()), double(met), double(through),
                 most, percentile(depths, 0.99), percentile(depths, 0.9), double(deep)});
      struck += static_cast<int>(depths.size());
      too_deep += deep;
      deepest = std::max(deepest, 1e-3 * most);
      passed += through;
    }
  }
  experiment.table("strikes", "Parts that strike at 10 m/s", table);
  experiment.record("impact.strike_deepest_m", deepest, "m");
  experiment.record("impact.strikes", struck, "count");
  experiment.record("impact.strikes_over_half_mm", too_deep, "count");
  experiment.record("impact.strikes_passed", passed, "count");
}

int run(int argc, char** argv) {
  Experiment experiment("impact", argc, argv);
  strikes(experiment);
  Drops(experiment).run();
  experiment.note(
      "Strikes: parts of any attitude that turn by up to 10 rad/s about each axis, at 10 m/s; each "
      "target has throws of its own. Met: the part has lost a tenth of its speed. Passed: it is "
      "beyond, or went into the table.");
  experiment.note(
      "Drops: every shipped part and tray. Half of them fall from 3 mm, tilted by up to 12 "
      "degrees, upright and upside down in turns, the others at any attitude. Rolling "
      "resistance is 0.5 mm as in the shipped cells. A drop ends when the body has rested for a "
      "second (below 1 mm/s and 0.01 "
      "rad/s); two of each are watched for ten minutes. Gains of energy are added up from the "
      "first touch on, also those of a single step that the next one takes away. In mode `off` "
      "resting bodies are solved in each step to the solver's tolerance, so such gains add up "
      "with time. Rise: the most by which energy was ever over any earlier one.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
