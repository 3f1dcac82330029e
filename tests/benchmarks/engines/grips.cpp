#include "tests/benchmarks/engines/grips.hpp"

#include <algorithm>
#include <map>

#include "tests/benchmarks/engines/engine_settings.hpp"
#include "tests/benchmarks/gripper/floating_grip.hpp"

namespace aprsim::bench {
namespace {

using Eigen::Vector3d;

/// The baselines of the paper, and its law.
const std::vector<GripperLawCase> kLaws = {{"constant", scene::GripperLaw::kConstant},
                                           {"mimic_pid", scene::GripperLaw::kMimicPid},
                                           {"coupled", scene::GripperLaw::kCoupled}};
const std::vector<Vector3d> kDirections = {{1, 0, 0},  {0, 1, 0}, {0, -1, 0}, {0, 0, 1},
                                           {0, 0, -1}, {1, 1, 1}, {1, -2, 1}};

/// The largest motion of the gear in the hand, over all directions.
struct Worst {
  double delta_m = 0, theta_rad = 0;
  int drops = 0;
};

struct GripSetting {
  EngineSetting engine;
  double step_ms = 1, pad_friction = 1;
};

Worst worst_of(const GripperLawCase& law, const GripSetting& setting, bool quick) {
  Worst worst;
  for (const double accel : quick ? std::vector{30.0} : std::vector{2.0, 10.0, 30.0}) {
    for (const Vector3d& direction : kDirections) {
      const Shake run = shake({.law = law,
                               .gear = "medium",
                               .pad_friction = setting.pad_friction,
                               .direction_T = direction,
                               .accel_m_s2 = accel,
                               .step_s = 1e-3 * setting.step_ms,
                               .engine = setting.engine.engine,
                               .ode = setting.engine.ode});
      worst.delta_m = std::max(worst.delta_m, run.delta_m);
      worst.theta_rad = std::max(worst.theta_rad, run.theta_rad);
      worst.drops += run.dropped;
    }
  }
  return worst;
}

/// One parameter at a time.
std::vector<GripSetting> grip_settings(bool quick) {
  std::vector<GripSetting> out;
  for (const EngineSetting& engine : engine_settings(quick)) {
    out.push_back({engine});
    if (quick) continue;
    for (const double step_ms : {0.5, 2.0}) out.push_back({engine, step_ms});
    for (const double friction : {0.5, 2.0}) out.push_back({engine, 1, friction});
  }
  return out;
}

}  // namespace

void compare_grips(Experiment& experiment) {
  Table table(
      {"engine", "step [ms]", "pad friction", "law", "delta_t [m]", "theta_t [rad]", "drops"});
  int contradictions = 0;
  for (const GripSetting& setting : grip_settings(experiment.quick())) {
    std::map<std::string, Worst> by_law;
    for (const GripperLawCase& law : kLaws) {
      const Worst worst = worst_of(law, setting, experiment.quick());
      by_law[law.name] = worst;
      table.row({setting.engine.name, setting.step_ms, setting.pad_friction, law.name,
                 worst.delta_m, worst.theta_rad, static_cast<double>(worst.drops)});
      if (setting.step_ms != 1 || setting.pad_friction != 1) continue;
      const std::string name = "engines.fig3." + setting.engine.key + "." + law.name;
      experiment.record(name + ".delta_m", worst.delta_m, "m");
      experiment.record(name + ".theta_rad", worst.theta_rad, "rad");
    }
    const Worst& coupled = by_law.at("coupled");
    for (const char* baseline : {"constant", "mimic_pid"}) {
      const Worst& other = by_law.at(baseline);
      contradictions += coupled.delta_m >= other.delta_m || coupled.drops > other.drops;
    }
  }
  experiment.table("fig3", "Fig. 3: largest motion of a gear in the hand, by engine and settings",
                   table);
  experiment.record("engines.fig3.contradictions", contradictions, "count");
}

}  // namespace aprsim::bench
