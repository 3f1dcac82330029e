// Table 1 of IMECE2019-11345: ten trays with forty gears on a moving belt. How still the gears lie
// in their trays, and how fast the scene runs, in every mode of contact simplification.

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/modes.hpp"
#include "tests/benchmarks/trays/tray_run.hpp"

namespace aprsim::bench {
namespace {

constexpr double kPaperStandardRtf = 0.43, kPaperSimplifiedRtf = 0.98;
constexpr double kPaperStandardDelta = 1.3e-2, kPaperSimplifiedDelta = 1.0e-3;

using Runs = std::map<std::string, TrayRun>;

/// How many times faster `mode` was than `off`.
double speedup(const Runs& runs, const std::string& mode) {
  return runs.at("off").cpu_s / runs.at(mode).cpu_s;
}

/// One run in each mode.
Runs run_modes(scene::Scene scene, const TrayRunPlan& plan) {
  Runs runs;
  for (const auto& mode : kModes) {
    scene.physics.simplification = mode.value;
    runs[mode.name] = run_trays(scene, plan);
  }
  return runs;
}

void main_table(Experiment& experiment, const Runs& runs) {
  Table table({"mode", "RTF", "us/step steady", "contacts/step", "delta from spawn [m]",
               "delta settled [m]", "theta from spawn [rad]", "theta settled [rad]"});
  for (const auto& mode : kModes) {
    const TrayRun& run = runs.at(mode.name);
    table.row({mode.name, run.real_time_factor, run.steady_us, run.contacts, run.delta_spawn_m,
               run.delta_settled_m, run.theta_spawn_rad, run.theta_settled_rad});
  }
  const double none = std::nan("");
  table.row(
      {"paper, standard", kPaperStandardRtf, none, none, kPaperStandardDelta, none, none, none});
  table.row({"paper, simplified", kPaperSimplifiedRtf, none, none, kPaperSimplifiedDelta, none,
             none, none});
  experiment.table("modes", "Ten trays, forty gears, 4 s", table);
}

void record_modes(Experiment& experiment, const Runs& runs) {
  for (const auto& mode : kModes) {
    const std::string name = "table1." + std::string(mode.name);
    const TrayRun& run = runs.at(mode.name);
    const double rtf = run.real_time_factor;
    const bool plain = mode.value == scene::Simplification::kOff;
    const double paper_rtf = plain ? kPaperStandardRtf : kPaperSimplifiedRtf;
    const double paper_delta = plain ? kPaperStandardDelta : kPaperSimplifiedDelta;
    const char* paper = plain ? "paper, standard" : "paper, simplified";
    experiment.record({name + ".rtf", rtf, "x", paper, rtf / paper_rtf});
    experiment.record(
        {name + ".delta_spawn_m", run.delta_spawn_m, "m", paper, run.delta_spawn_m / paper_delta});
    experiment.record(name + ".delta_settled_m", run.delta_settled_m, "m");
    experiment.record(name + ".theta_spawn_rad", run.theta_spawn_rad, "rad");
    experiment.record(name + ".tray_travel_error_m", run.tray_travel_error_m, "m");
    if (plain) continue;
    const double ratio = speedup(runs, mode.name);
    experiment.record({name + "_over_off", ratio, "x", "off", ratio});
  }
}

struct Variation {
  std::string parameter;
  double value;
  std::function<void(scene::Scene&)> apply;
};

std::vector<Variation> variations(bool quick) {
  std::vector<Variation> out;
  const auto add = [&](const std::string& parameter, std::vector<double> values, const auto& set) {
    if (quick) values.resize(1);
    for (const double value : values) {
      out.push_back({parameter, value, [=](scene::Scene& scene) { set(scene, value); }});
    }
  };
  add("step [ms]", {0.5, 2, 4},
      [](scene::Scene& scene, double ms) { scene.physics.step_s = 1e-3 * ms; });
  add("friction", {0.2, 0.7, 1},
      [](scene::Scene& scene, double mu) { scene.physics.friction.gear_tray = mu; });
  add("gear mass factor", {0.1, 5, 20}, [](scene::Scene& scene, double factor) {
    for (auto& [name, type] : scene.gear_types) type.mass_kg *= factor;
  });
  return out;
}

/// "Regardless of the simulation parameters": each parameter on its own, in every mode.
void sweep(Experiment& experiment, const scene::Scene& base, TrayRunPlan plan) {
  Table table({"parameter", "value", "mode", "RTF", "over off", "delta from spawn [m]",
               "delta settled [m]"});
  std::map<std::string, double> least_speedup, worst_settled;
  std::map<std::string, Series> by_step;
  for (const auto& variation : variations(experiment.quick())) {
    scene::Scene scene = base;
    variation.apply(scene);
    const Runs runs = run_modes(scene, plan);
    for (const auto& mode : kModes) {
      const TrayRun& run = runs.at(mode.name);
      const double ratio = speedup(runs, mode.name);
      table.row({variation.parameter, variation.value, mode.name, run.real_time_factor, ratio,
                 run.delta_spawn_m, run.delta_settled_m});
      const auto [least, first] = least_speedup.try_emplace(mode.name, ratio);
      least->second = std::min(least->second, ratio);
      worst_settled[mode.name] = std::max(worst_settled[mode.name], run.delta_settled_m);
      if (variation.parameter == "step [ms]") {
        by_step[mode.name].name = mode.name;
        by_step[mode.name].points.emplace_back(variation.value, run.real_time_factor);
      }
    }
  }
  experiment.table("sweep", "The same over simulation parameters, one at a time, 2 s", table);
  for (const auto& mode : kModes) {
    const std::string name = "table1.sweep." + std::string(mode.name);
    experiment.record(name + ".worst_delta_settled_m", worst_settled[mode.name], "m");
    if (mode.value == scene::Simplification::kOff) continue;
    experiment.record(
        {name + ".least_over_off", least_speedup[mode.name], "x", "off", least_speedup[mode.name]});
  }
  Plot plot{.title = "Table 1 scene: real-time factor over step",
            .x = {.label = "step [ms]", .log = true},
            .y = {.label = "simulated s per CPU s", .log = true}};
  for (const auto& [mode, series] : by_step) plot.series.push_back(series);
  experiment.plot("step", plot);
}

void parameters_of_paper(Experiment& experiment, const Runs& runs) {
  experiment.note(
      "Gears start touching their tray, each turned by a random angle and up to 0.15 mm off its "
      "slot's centre (radial clearance of the pockets: 0.2 mm); \"centred\" is the scene file as "
      "it "
      "is. The belt stands for 0.5 s (\"settled\" counts from there), then runs up to 0.3 m/s.");
  experiment.note(
      "Times are of a single run of each mode, in which the poses of all bodies are read after "
      "every "
      "step, as the daemon does for its snapshots. The gains of `merge` and `dormant` come from "
      "rest relative to a moving carrier; experiment `awake` shows the solver alone.");
  experiment.note(
      "A figure after settling is small by construction in the modes that join parts; what they "
      "may "
      "not do is hold a part that friction would not, which experiment `breakup` measures.");
  for (const auto& [mode, run] : runs) {
    if (run.tray_travel_error_m > 0.01) {
      experiment.note("In mode " + mode + " a tray did not follow the belt.");
    }
  }
}

void figures(Experiment& experiment, const scene::Scene& centred, const Runs& runs,
             const TrayRunPlan& plan) {
  scene::Scene scene = centred;
  const char* best = kDefaultMode.name;
  scene.physics.simplification = kDefaultMode.value;
  const TrayRun aligned = run_trays(scene, plan);
  experiment.record("table1.centred.delta_spawn_m", aligned.delta_spawn_m, "m");
  experiment.record({"table1.delta_spawn_m", runs.at(best).delta_spawn_m, "m", "paper, simplified",
                     runs.at(best).delta_spawn_m / kPaperSimplifiedDelta});
  experiment.record("table1.delta_settled_m", runs.at(best).delta_settled_m, "m");
}

int run(int argc, char** argv) {
  Experiment experiment("table1", argc, argv);
  const scene::Scene centred = shipped_scene("table1");
  scene::Scene scene = centred;
  disturb_gears(scene, 1);
  TrayRunPlan plan;
  if (experiment.quick()) plan.duration_s = 1;
  const Runs runs = run_modes(scene, plan);
  main_table(experiment, runs);
  record_modes(experiment, runs);
  figures(experiment, centred, runs, plan);
  parameters_of_paper(experiment, runs);
  plan.duration_s = std::min(plan.duration_s, 2.0);
  sweep(experiment, scene, plan);
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
