#include <ostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/commands.hpp"
#include "clients/aprsim/scenario/report.hpp"
#include "clients/aprsim/scenario/runner.hpp"
#include "clients/aprsim/sweep/run_sweep.hpp"
#include "world/scenario/plan.hpp"
#include "world/scenario/scenario_reader.hpp"

namespace aprsim::client {
namespace {

Failure wrong_file(const Error& error) { return {FailureKind::kUsage, error.message}; }

}  // namespace

Outcome<void> run_command(const ScenarioListCommand& /*command*/, Console& console) {
  const auto paths = scene::default_data_paths();
  for (const auto& name : scene::names_in(paths.scenarios)) {
    const auto description = scenario::describe_scenario(name, paths);
    if (!description) return tl::unexpected(wrong_file(description.error()));
    console.show(fmt::format("{:<24} {}\n", name, *description),
                 {{"name", name}, {"description", *description}});
  }
  return {};
}

Outcome<void> run_command(const ScenarioCheckCommand& command, Console& console) {
  const auto paths = scene::default_data_paths();
  const auto scenario = scenario::load_scenario(command.name, paths);
  if (!scenario) return tl::unexpected(wrong_file(scenario.error()));
  const auto plan = scenario::plan(*scenario, command.seed, paths);
  if (!plan) return tl::unexpected(wrong_file(plan.error()));
  unsigned kits = 0;
  for (const auto& order : scenario->orders) kits += order.count;
  console.show(fmt::format("{} is in order: {} kits, {} faults, at most {} s\n", scenario->file,
                           kits, scenario->faults.size(), scenario->stop.time_limit_s),
               {{"name", scenario->name},
                {"file", scenario->file},
                {"scene", scenario->scene_file},
                {"kits", kits},
                {"faults", scenario->faults.size()},
                {"time_limit_s", scenario->stop.time_limit_s}});
  return {};
}

Outcome<void> run_command(const ScenarioRunCommand& command, Console& console) {
  if (command.repeat) return run_sweep(command, console);
  const auto paths = scene::default_data_paths();
  const auto scenario = scenario::load_scenario(command.name, paths);
  if (!scenario) return tl::unexpected(wrong_file(scenario.error()));
  const auto plan = scenario::plan(*scenario, command.seed, paths);
  if (!plan) return tl::unexpected(wrong_file(plan.error()));
  const auto tell = [&](const RunEvent& event) {
    if (console.json) return;
    console.out << fmt::format("{:8.2f} s  {}\n", event.time_s, event.what) << std::flush;
  };
  const auto run = run_scenario(*scenario, *plan,
                                {.speed = command.speed,
                                 .virtual_time = command.virtual_time,
                                 .controller = command.controller,
                                 .directory = command.report},
                                tell);
  if (!run) return tl::unexpected(run.error());
  console.show('\n' + report_table(*run, console.screen.out), report_json(*run));
  if (!command.report.empty()) {
    if (auto written = write_report(*run, command.report); !written) return written;
  }
  if (run->as_expected()) return {};
  std::string broken;
  for (const Verdict& verdict : run->verdicts) {
    if (!verdict.kept) broken += (broken.empty() ? "" : "; ") + text_of(verdict);
  }
  return failed(FailureKind::kCheck, "not as expected: " + broken);
}

}  // namespace aprsim::client
