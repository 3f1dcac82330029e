#include <ostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/commands.hpp"
#include "clients/aprsim/scenario/report.hpp"
#include "clients/aprsim/scenario/runner.hpp"
#include "world/scenario/plan.hpp"
#include "world/scenario/scenario_reader.hpp"

namespace aprsim::client {
namespace {

Failure wrong_file(const Error& error) { return {FailureKind::kUsage, error.message}; }

nlohmann::ordered_json progress_json(const RunProgress& progress) {
  auto orders = nlohmann::ordered_json::array();
  for (const OrderProgress& order : progress.orders) {
    orders.push_back({{"name", order.name},
                      {"tray", order.tray},
                      {"state", order.state},
                      {"kits", order.kits},
                      {"done", order.submitted},
                      {"parts", order.parts},
                      {"parts_wanted", order.parts_wanted}});
  }
  return {
      {"progress", {{"time_s", progress.time_s}, {"placed", progress.placed}, {"orders", orders}}}};
}

/// Tells of a run on the console, for people or, by --progress, for programs.
RunListener listener_of(const ScenarioRunCommand& command, Console& console) {
  RunListener listener;
  if (command.progress) {
    listener.event = [&](const RunEvent& event) {
      const nlohmann::ordered_json line{{"time_s", event.time_s}, {"what", event.what}};
      console.out << line.dump() << std::endl;
    };
    listener.progress = [&](const RunProgress& progress) {
      console.out << progress_json(progress).dump() << std::endl;
    };
  } else if (!console.json) {
    listener.event = [&](const RunEvent& event) {
      console.out << fmt::format("{:8.2f} s  {}\n", event.time_s, event.what) << std::flush;
    };
  }
  return listener;
}

}  // namespace

Outcome<void> run_command(const ScenarioListCommand& /*command*/, Console& console) {
  const auto paths = scene::default_data_paths();
  for (const auto& name : scene::names_in(paths.scenarios)) {
    const auto summary = scenario::summarize_scenario(name, paths);
    if (!summary) return tl::unexpected(wrong_file(summary.error()));
    console.show(fmt::format("{:<24} {}\n", name, summary->description),
                 {{"name", name}, {"description", summary->description}});
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
  const auto paths = scene::default_data_paths();
  const auto scenario = scenario::load_scenario(command.name, paths);
  if (!scenario) return tl::unexpected(wrong_file(scenario.error()));
  const auto plan = scenario::plan(*scenario, command.seed, paths);
  if (!plan) return tl::unexpected(wrong_file(plan.error()));
  RunOptions options{.speed = command.speed,
                     .virtual_time = command.virtual_time,
                     .controller = command.controller,
                     .directory = command.report,
                     .journal = command.journal};
  if (command.attach) options.cell = RunningCell{console.endpoints, console.ports_file};
  const auto run = run_scenario(*scenario, *plan, options, listener_of(command, console));
  if (!run) return tl::unexpected(run.error());
  const std::string table = report_table(*run, console.screen.out);
  if (command.progress && !console.json) {
    console.out << nlohmann::ordered_json{{"report", table}}.dump() << std::endl;
  } else {
    console.show('\n' + table, report_json(*run));
  }
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
