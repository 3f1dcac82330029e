#include "clients/aprsim/commands/scenario_commands.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <ostream>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/commands/batch_commands.hpp"
#include "clients/aprsim/commands/file_commands.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/scenario/report.hpp"
#include "clients/aprsim/scenario/run_programs.hpp"
#include "clients/aprsim/scenario/runner.hpp"
#include "world/base/files/draft_file.hpp"
#include "world/scenario/plan.hpp"
#include "world/scenario/scenario_reader.hpp"

namespace aprsim::client {
namespace {

constexpr std::size_t kMostSeedsNamed = 10;

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

/// Reports a run on the console, for people or, with --progress, for programs.
RunListener listener_of(const ScenarioRunCommand& command, Console& console) {
  RunListener listener;
  if (command.progress) {
    listener.event = [&](const RunEvent& event) {
      console.print_json({{"time_s", event.time_s}, {"event", event.text}});
    };
    listener.progress = [&](const RunProgress& progress) {
      console.print_json(progress_json(progress));
    };
  } else if (!console.json) {
    listener.event = [&](const RunEvent& event) {
      console.print(fmt::format("{:8.2f} s  {}\n", event.time_s, event.text));
    };
  }
  return listener;
}

void add_scenario_name(CLI::App& app, std::string& name, std::uint64_t& seed) {
  app.add_option("NAME", name, "Name from 'scenario list', or a file")
      ->check(not_empty())
      ->required();
  app.add_option("--seed", seed, "Random seed (default 1)")->type_name("N");
}

/// Runs a batch of seeds from the command's seed on; without --report in a temporary directory.
Outcome<void> repeat(const ScenarioRunCommand& command, Console& console) {
  const RunDirectory directory(command.report);
  BatchCommand batch{.scenario = command.name,
                     .out = command.report.empty() ? directory.file("batch") : command.report,
                     .jobs = command.jobs,
                     .journals = 0,
                     .controller = command.controller,
                     .patience_s = command.patience_s};
  for (unsigned i = 0; i < command.repeat; ++i) batch.seeds.push_back(command.seed + i);
  const auto done = run_and_show(batch, !command.report.empty(), console);
  if (!done) return tl::unexpected(done.error());
  std::string seeds;
  std::size_t unexpected = 0;
  for (const auto& [seed, episode] : done->episodes) {
    if (episode.as_expected) continue;
    if (++unexpected <= kMostSeedsNamed) seeds += fmt::format(" {}", seed);
  }
  if (unexpected == 0) return {};
  return failed(FailureKind::kCheck,
                fmt::format("{} of {} runs not as expected; seeds{}{}", unexpected, command.repeat,
                            seeds, unexpected > kMostSeedsNamed ? " ..." : ""));
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

namespace {

/// Draws a run of a scenario without errors.
Outcome<void> show_valid_scenario(const std::string& file, std::uint64_t seed, Console& console) {
  const auto paths = scene::default_data_paths();
  const auto scenario = scenario::load_scenario(file, paths);
  if (!scenario) return tl::unexpected(wrong_file(scenario.error()));
  const auto plan = scenario::plan(*scenario, seed, paths);
  if (!plan) return tl::unexpected(wrong_file(plan.error()));
  unsigned kits = 0;
  for (const auto& order : scenario->orders) kits += order.count;
  console.show(fmt::format("{} is valid: {} kits, {} faults, at most {} s\n", scenario->name, kits,
                           scenario->faults.size(), scenario->stop.time_limit_s),
               {{"name", scenario->name},
                {"file", scenario->file},
                {"scene", scenario->scene_file},
                {"kits", kits},
                {"faults", scenario->faults.size()},
                {"time_limit_s", scenario->stop.time_limit_s}});
  return {};
}

}  // namespace

Outcome<void> run_command(const ScenarioCheckCommand& command, Console& console) {
  return check_files(FileKind::kScenario, command.files, console, [&](const CheckedFile& checked) {
    return show_valid_scenario(checked.file, command.seed, console);
  });
}

namespace {

/// Checks that neither the report nor the journal of a run replaces the scenario or its scene.
Outcome<void> check_run_outputs(const ScenarioRunCommand& command,
                                const scenario::Scenario& scenario) {
  std::vector<std::string> outputs;
  if (!command.report.empty()) {
    outputs = report_files(command.report);
    const auto run = RunDirectory::files(command.report);
    outputs.insert(outputs.end(), run.begin(), run.end());
  }
  if (!command.journal.empty()) outputs.push_back(command.journal);
  const std::array inputs{scenario.file, scenario.scene_file};
  if (auto apart = files::check_outputs(inputs, outputs); !apart) {
    return tl::unexpected(wrong_file(apart.error()));
  }
  return {};
}

}  // namespace

Outcome<void> run_command(const ScenarioRunCommand& command, Console& console) {
  const auto paths = scene::default_data_paths();
  const auto scenario = scenario::load_scenario(command.name, paths);
  if (!scenario) return tl::unexpected(wrong_file(scenario.error()));
  if (auto apart = check_run_outputs(command, *scenario); !apart) return apart;
  if (command.repeat > 0) return repeat(command, console);
  const auto plan = scenario::plan(*scenario, command.seed, paths);
  if (!plan) return tl::unexpected(wrong_file(plan.error()));
  RunOptions options{.speed = command.speed,
                     .virtual_time = command.virtual_time,
                     .controller = command.controller,
                     .directory = command.report,
                     .journal = command.journal,
                     .patience = std::chrono::seconds(command.patience_s)};
  if (command.attach) options.cell = RunningCell{console.endpoints, console.ports_file};
  const auto run = run_scenario(*scenario, *plan, options, listener_of(command, console));
  if (!run) return tl::unexpected(run.error());
  const std::string table = report_table(*run, console.screen.out);
  if (command.progress && !console.json) {
    console.print_json({{"report", table}});
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

namespace {

void add_scenario_run(CLI::App& scenario, CommandLine& line) {
  auto [run, command] =
      add_command<ScenarioRunCommand>(scenario, line, "run",
                                      "Run a scenario, in its own daemon or in the "
                                      "running cell, and compare the outcome with the "
                                      "expectations");
  add_scenario_name(*run, command->name, command->seed);
  run->add_option_function<std::string>(
         "--speed",
         [c = command](const std::string& text) { c->speed = factor_of("--speed", text); },
         "Ratio of simulated to wall time: 0.001 to 1e6, or max (default 1)")
      ->type_name("X");
  CLI::Option* polls = run->add_flag(
      "--virtual", command->virtual_time,
      "Use virtual time: the controller's polls advance it, and equal seeds give equal reports");
  polls->excludes("--speed");
  CLI::Option* attach =
      run->add_flag("--attach", command->attach,
                    "Reset the running cell and run there, without the variations of the scene");
  attach->excludes(polls);
  run->add_flag("--progress", command->progress,
                "Report events and the progress of orders, as one JSON object per line");
  CLI::Option* journal =
      run->add_option("--journal", command->journal, "File or directory for the journal of the run")
          ->type_name("FILE|DIR")
          ->check(not_empty())
          ->excludes(attach);
  CLI::Option* repeat = run->add_option("--repeat", command->repeat,
                                        "Run N seeds from --seed on as a batch, in virtual time")
                            ->type_name("N")
                            ->check(CLI::Range(1, 1'000'000))
                            ->excludes("--speed")
                            ->excludes(attach)
                            ->excludes(journal)
                            ->excludes("--progress");
  command->jobs = std::max(1U, std::thread::hardware_concurrency());
  run->add_option("--jobs", command->jobs, "Parallel runs (default: number of processors)")
      ->type_name("J")
      ->check(CLI::Range(1, 256))
      ->needs(repeat);
  run->add_option(
         "--controller", command->controller,
         "Shell command of the controller (default: the scenario's program); none waits for "
         "a controller that is already running")
      ->type_name("CMD")
      ->check(not_empty());
  add_patience(*run, command->patience_s);
  run->add_option("--report", command->report,
                  "Directory for report.json, report.txt, report.html, scene and logs")
      ->type_name("DIR")
      ->check(not_empty());
  offer_json(*run, line, "Print the report as one JSON object");
}

}  // namespace

void add_scenario(CLI::App& app, CommandLine& line) {
  CLI::App* scenario =
      app.add_subcommand("scenario", "Run and evaluate scenarios, and work with their files");
  scenario->require_subcommand(1);
  auto [list, list_command] = add_command<ScenarioListCommand>(
      *scenario, line, "list", "List the shipped scenarios; needs no daemon");
  offer_json(*list, line);
  auto [check, check_command] = add_command<ScenarioCheckCommand>(
      *scenario, line, "check", "Check scenarios without running them; needs no daemon");
  check->add_option("FILE", check_command->files, "Names from 'scenario list', or files")
      ->check(not_empty())
      ->required();
  check->add_option("--seed", check_command->seed, "Random seed (default 1)")->type_name("N");
  offer_json(*check, line, "Print one JSON object per problem and per valid scenario");
  add_file_commands(*scenario, line, FileKind::kScenario);
  add_scenario_run(*scenario, line);
}

}  // namespace aprsim::client
