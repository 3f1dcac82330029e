// Parts in hands that turn about any axis: how far they drift in the hand.

#include <algorithm>
#include <vector>

#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/in_parallel.hpp"
#include "tests/benchmarks/support/modes.hpp"
#include "tests/benchmarks/turning/held_part.hpp"

namespace aprsim::bench {
namespace {

using Eigen::Isometry3d;

constexpr std::array kGrasps = {Grasp::kFlatPads, Grasp::kVPads, Grasp::kTrayByEdge, Grasp::kCup};
constexpr int kFirst = 10;         // turns in which a part may settle
constexpr double kSettling = 0.3;  // at rest before each look [s]

struct Look {
  int turns = 0;
  double drift_m = 0;
};

/// Motion of a part in the hand, from rest to rest.
struct Drift {
  double m = 0, rad = 0;  ///< in all
  double first_m = 0;     ///< in the first turns
  double growth_m = 0;    ///< after them
  bool held = false;      ///< before the first turn and after the last one
  std::vector<Look> looks;
};

double distance(const Isometry3d& a, const Isometry3d& b) {
  return (a.translation() - b.translation()).norm();
}

Drift drift_of(const HeldPart::Setting& setting, int turns) {
  HeldPart part(setting);
  Drift out;
  out.held = part.holding();
  std::mt19937_64 engine(44 + static_cast<unsigned>(setting.grasp));
  const Isometry3d start = part.place();
  Isometry3d settled = start;
  for (int done = 1; done <= turns; ++done) {
    part.swing(random_turn(engine));
    const bool round = done <= kFirst ? done == 1 || done == 3 : done % kFirst == 0;
    if (!round && done != kFirst && done != turns) continue;
    part.rest(kSettling);
    out.looks.push_back({done, distance(start, part.place())});
    if (done == kFirst) settled = part.place();
  }
  const Isometry3d end = part.place();
  out.m = distance(start, end);
  out.rad = physics::test::angle_between(start, end);
  out.first_m = distance(start, settled);
  out.growth_m = turns > kFirst ? distance(settled, end) : 0;
  out.held = out.held && part.holding();
  return out;
}

/// Worst of several.
struct Worst {
  double m = 0, rad = 0, first_m = 0, growth_m = 0;
  int lost = 0;
  void add(const Drift& drift) {
    m = std::max(m, drift.m);
    rad = std::max(rad, drift.rad);
    first_m = std::max(first_m, drift.first_m);
    growth_m = std::max(growth_m, drift.growth_m);
    lost += drift.held ? 0 : 1;
  }
};

void record(Experiment& experiment, const std::string& name, const Worst& worst) {
  experiment.record(name + ".drift_m", worst.m, "m");
  experiment.record(name + ".drift_rad", worst.rad, "rad");
  experiment.record(name + ".first_ten_m", worst.first_m, "m");
  experiment.record(name + ".growth_m", worst.growth_m, "m");
}

void all_modes(Experiment& experiment) {
  const int turns = experiment.quick() ? 11 : 1000;
  const auto drifts = in_parallel(kGrasps.size() * kModes.size(), [&](std::size_t i) {
    return drift_of({.grasp = kGrasps[i / kModes.size()], .mode = kModes[i % kModes.size()].value},
                    turns);
  });
  Table table({"grasp", "mode", "turns", "drift [m]", "turned by [rad]", "first ten turns [m]",
               "after them [m]", "held"});
  Plot plot{.title = "Drift in a hand that turns there and back, mode dormant",
            .x = {.label = "turns", .log = true},
            .y = {.label = "drift [m]", .log = true, .floor = 1e-12}};
  Worst all;
  for (std::size_t i = 0; i < drifts.size(); ++i) {
    const Mode& mode = kModes[i % kModes.size()];
    const std::string grasp = name_of(kGrasps[i / kModes.size()]);
    const Drift& drift = drifts[i];
    table.row({grasp, mode.name, double(turns), drift.m, drift.rad, drift.first_m, drift.growth_m,
               drift.held ? "yes" : "no"});
    all.add(drift);
    if (mode.value != kDefaultMode.value) continue;
    Series series{.name = grasp};
    for (const Look& look : drift.looks) series.points.emplace_back(look.turns, look.drift_m);
    plot.series.push_back(std::move(series));
  }
  for (std::size_t g = 0; g < kGrasps.size(); ++g) {
    Worst own;
    for (std::size_t m = 0; m < kModes.size(); ++m) own.add(drifts[g * kModes.size() + m]);
    record(experiment, std::string("turning.") + name_of(kGrasps[g]), own);
  }
  experiment.table("turns", "Drift in the hand, at rest before and after", table);
  experiment.plot("turns", plot);
  record(experiment, "turning", all);
  experiment.record("turning.lost", all.lost, "count");
}

void other_steps(Experiment& experiment) {
  const int turns = experiment.quick() ? 2 : 50;
  constexpr std::array kSteps = {2e-3, 1e-3, 5e-4, 2.5e-4};
  const auto drifts = in_parallel(kGrasps.size() * kSteps.size(), [&](std::size_t i) {
    return drift_of({.grasp = kGrasps[i / kSteps.size()], .step_s = kSteps[i % kSteps.size()]},
                    turns);
  });
  Table table({"grasp", "step [ms]", "turns", "drift [m]", "turned by [rad]", "first ten turns [m]",
               "after them [m]", "held"});
  Worst all;
  for (std::size_t i = 0; i < drifts.size(); ++i) {
    const Drift& drift = drifts[i];
    table.row({name_of(kGrasps[i / kSteps.size()]), 1e3 * kSteps[i % kSteps.size()], double(turns),
               drift.m, drift.rad, drift.first_m, drift.growth_m, drift.held ? "yes" : "no"});
    all.add(drift);
  }
  experiment.table("steps", "The same with other steps, mode dormant", table);
  record(experiment, "turning.other_steps", all);
  experiment.record("turning.other_steps.lost", all.lost, "count");
}

int run(int argc, char** argv) {
  Experiment experiment("turning", argc, argv);
  all_modes(experiment);
  other_steps(experiment);
  experiment.note(
      "Hands turn there and back about any axis through any point within 0.1 m of the tool tip. "
      "Each turn has 0.2 to 2 rad, a rate up to 2 to 6 rad/s, angular acceleration up to 20 to 60 "
      "rad/s2, quintic "
      "profile. Gear of 19 g by its peg and tray of 0.2 kg by its edge between pads of 60 N and "
      "friction 0.7; disc of 50 g under a cup that draws 27 N. The loads stay below a third of "
      "the friction limit. The drift is the distance between the places in the hand, each after "
      "0.3 s at rest; the first ten turns, in which a part settles, also count apart.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
