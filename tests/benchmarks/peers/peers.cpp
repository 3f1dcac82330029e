// The Table 1 scene in other engines next to our own physics, in one run.

#include <functional>
#include <map>

#include "tests/benchmarks/peers/peer_engine.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/modes.hpp"
#include "tests/benchmarks/trays/tray_run.hpp"

namespace aprsim::bench {
namespace {

constexpr double kSunk = 5e-4;  // what our own physics reports as a fault [m]

struct Contender {
  std::string engine, settings;
  std::function<std::unique_ptr<TraySimulation>()> make;
  TrayRun run;

  /// Trays ride with the belt, gears stay in their pockets and do not sink.
  [[nodiscard]] bool plausible() const {
    return run.tray_travel_error_m < 0.05 && run.deepest_m < kSunk && run.delta_settled_m < 0.4;
  }
};

/// Scenes of our own modes; they must outlive the contenders.
using Scenes = std::map<std::string, scene::Scene>;

std::vector<Contender> contenders(const Scenes& scenes, const std::vector<PeerEngine>& peers) {
  std::vector<Contender> out;
  for (const auto& mode : kModes) {
    const scene::Scene& own = scenes.at(mode.name);
    out.push_back({"aprsim", mode.name, [&own] { return own_simulation(own); }, {}});
  }
  const scene::Scene& scene = scenes.at("off");
  for (const auto& peer : peers) {
    for (const auto& settings : peer.settings) {
      out.push_back(
          {peer.name, settings.name, [&scene, make = settings.make] { return make(scene); }, {}});
    }
  }
  return out;
}

void show(Experiment& experiment, const std::vector<Contender>& all, double duration_s) {
  Table table({"engine", "settings", "RTF", "contacts/step", "delta from spawn [m]",
               "delta settled [m]", "deepest sunk [m]", "tray off the belt's way [m]",
               "plausible"});
  for (const auto& contender : all) {
    const TrayRun& run = contender.run;
    table.row({contender.engine, contender.settings, duration_s / contender.run.cpu_s, run.contacts,
               run.delta_spawn_m, run.delta_settled_m, run.deepest_m, run.tray_travel_error_m,
               contender.plausible() ? "yes" : "no"});
  }
  experiment.table("engines", "Table 1 scene in other engines", table);
  Plot plot{.title = "Table 1 scene: stillness over speed",
            .x = {.label = "simulated s per CPU s", .log = true},
            .y = {.label = "cumulative delta_t after settling [m]", .log = true, .floor = 1e-14}};
  for (const auto& contender : all) {
    plot.series.push_back({contender.engine + " " + contender.settings,
                           {{duration_s / contender.run.cpu_s, contender.run.delta_settled_m}}});
  }
  experiment.plot("engines", plot);
}

/// Against the fastest settings of an engine with which the scene is still the scene.
void compare(Experiment& experiment, const std::vector<Contender>& all, const PeerEngine& peer) {
  const Contender* own = nullptr;
  const Contender* best = nullptr;
  for (const auto& contender : all) {
    if (contender.engine == "aprsim" && contender.settings == kDefaultMode.name) own = &contender;
    if (contender.engine != peer.name || !contender.plausible()) continue;
    if (best == nullptr || contender.run.cpu_s < best->run.cpu_s) best = &contender;
  }
  if (best == nullptr) {
    experiment.note(peer.name + ": no settings kept the gears in their pockets; not compared.");
    return;
  }
  const std::string name = peer.name + ", " + best->settings;
  const auto record = [&](const std::string& figure, const Contender& ours) {
    const double ratio = best->run.cpu_s / ours.run.cpu_s;
    experiment.record({"table1." + figure + peer.short_name, ratio, "x", name, ratio});
  };
  record("over_", *own);
  record("off_over_", all.front());
  experiment.record(
      {"table1." + peer.short_name + ".delta_settled_m", best->run.delta_settled_m, "m"});
  experiment.record({"table1." + peer.short_name + ".delta_spawn_m", best->run.delta_spawn_m, "m"});
}

int run(int argc, char** argv) {
  Experiment experiment("peers", argc, argv);
  scene::Scene scene = shipped_scene("table1");
  disturb_gears(scene, 1, 1e-4);
  TrayRunPlan plan;
  if (experiment.quick()) plan.duration_s = 0.6;
  Scenes scenes;
  for (const auto& mode : kModes) {
    scenes[mode.name] = scene;
    scenes[mode.name].physics.simplification = mode.value;
  }
  const auto peers = peer_engines();
  auto all = contenders(scenes, peers);
  for (auto& contender : all) {
    const auto simulation = contender.make();
    contender.run = run_trays(*simulation, scene, plan);
  }
  show(experiment, all, plan.duration_s);
  for (const auto& mode : kModes) {
    for (const auto& contender : all) {
      if (contender.engine != "aprsim" || contender.settings != mode.name) continue;
      experiment.record("peers.aprsim." + contender.settings + ".rtf",
                        plan.duration_s / contender.run.cpu_s, "x");
    }
  }
  experiment.note(
      "In the other engines a tray is boxes with square holes and a gear is two cylinders. "
      "Clearance, masses, friction, step and solver iterations are the same unless the "
      "settings say otherwise. The belt is a body moved at the belt's speed. Compared is the "
      "fastest setting with which gears "
      "stay "
      "in their pockets and sink less than 0.5 mm (\"plausible\"). Sleeping is off: what rides a "
      "belt "
      "would fall asleep.");
  experiment.note(
      "A single run of each, all poses read after every step. `table1.over_*` is our default mode, "
      "whose gain is rest on a moving carrier; `table1.off_over_*` is our solver alone.");
  for (const auto& peer : peers) {
    experiment.version(peer.name, peer.version);
    compare(experiment, all, peer);
  }
  if (peers.empty()) experiment.note("Built without other engines (APRSIM_PEERS is empty).");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
