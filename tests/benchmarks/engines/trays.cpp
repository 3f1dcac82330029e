#include "tests/benchmarks/engines/trays.hpp"

#include "tests/benchmarks/engines/engine_settings.hpp"
#include "tests/benchmarks/trays/tray_run.hpp"

namespace aprsim::bench {
namespace {

struct TraySetting {
  EngineSetting engine;
  double step_ms = 1, friction_factor = 1;
};

/// One parameter at a time.
std::vector<TraySetting> tray_settings(bool quick) {
  std::vector<TraySetting> out;
  for (const EngineSetting& engine : engine_settings(quick)) {
    out.push_back({engine});
    if (quick) continue;
    for (const double step_ms : {0.5, 2.0}) out.push_back({engine, step_ms});
    for (const double factor : {0.5, 2.0}) out.push_back({engine, 1, factor});
  }
  return out;
}

TrayRun run_setting(const scene::Scene& base, const TraySetting& setting,
                    scene::Simplification mode, const TrayRunPlan& plan) {
  scene::Scene scene = base;
  setting.engine.apply(scene.physics);
  scene.physics.simplification = mode;
  scene.physics.step_s = 1e-3 * setting.step_ms;
  scene.physics.friction.gear_tray *= setting.friction_factor;
  scene.physics.friction.tray_belt *= setting.friction_factor;
  return run_trays(scene, plan);
}

}  // namespace

void compare_trays(Experiment& experiment) {
  scene::Scene scene = shipped_scene("table1");
  disturb_gears(scene, 1);
  const TrayRunPlan plan{.duration_s = experiment.quick() ? 0.7 : 2};
  Table table({"engine", "step [ms]", "friction factor", "mode", "RTF", "contacts/step",
               "delta from spawn [m]", "delta settled [m]"});
  int contradictions = 0;
  for (const TraySetting& setting : tray_settings(experiment.quick())) {
    const auto run = [&](const char* mode, scene::Simplification value) {
      const TrayRun of_mode = run_setting(scene, setting, value, plan);
      table.row({setting.engine.name, setting.step_ms, setting.friction_factor, mode,
                 of_mode.real_time_factor, of_mode.contacts, of_mode.delta_spawn_m,
                 of_mode.delta_settled_m});
      if (setting.step_ms == 1 && setting.friction_factor == 1) {
        const std::string name = "engines.table1." + setting.engine.key + "." + mode;
        experiment.record(name + ".rtf", of_mode.real_time_factor, "x");
        experiment.record(name + ".delta_spawn_m", of_mode.delta_spawn_m, "m");
        experiment.record(name + ".delta_settled_m", of_mode.delta_settled_m, "m");
      }
      return of_mode;
    };
    const TrayRun off = run("off", scene::Simplification::kOff);
    const TrayRun joints = run("virtual_joints", scene::Simplification::kVirtualJoints);
    if (setting.step_ms == 1 && setting.friction_factor == 1) {
      const double ratio = joints.real_time_factor / off.real_time_factor;
      experiment.record({"engines.table1." + setting.engine.key + ".virtual_joints_over_off", ratio,
                         "x", "off", ratio});
    }
    contradictions += setting.engine.is_ode() && joints.delta_settled_m >= off.delta_settled_m;
    if (setting.engine.is_ode()) continue;
    static_cast<void>(run("dormant", scene::Simplification::kDormant));
  }
  experiment.table("table1", "Table 1: ten trays, forty gears, by engine and settings", table);
  experiment.record("engines.table1.contradictions", contradictions, "count");
}

}  // namespace aprsim::bench
