#include "clients/aprsim/commands/batch_commands.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <ostream>
#include <thread>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/batch/batch_report.hpp"
#include "clients/aprsim/batch/batch_results.hpp"
#include "clients/aprsim/batch/report_diff.hpp"
#include "clients/aprsim/batch/run_batch.hpp"
#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"

namespace aprsim::client {

Outcome<Batch> run_and_show(const BatchCommand& command, bool kept, Console& console) {
  auto outcome = run_batch({.scenario = command.scenario,
                            .seeds = share_of(command.seeds, command.shard),
                            .directory = command.out,
                            .jobs = command.jobs,
                            .tries = command.tries,
                            .journals = command.journals,
                            .controller = command.controller,
                            .reuse_controller = command.reuse_controller,
                            .patience = std::chrono::seconds(command.patience_s)},
                           console.json ? nullptr : &std::cerr, isatty(STDERR_FILENO) == 1);
  if (!outcome) return tl::unexpected(outcome.error());
  const double rate = static_cast<double>(outcome->run_now) / std::max(1e-3, outcome->wall_s);
  std::string text = batch_table(outcome->batch);
  text += fmt::format(
      "\n{} run{} in {:.1f} s: {:.2f} per second; {} repeated attempts; peak memory of a world "
      "{:.0f} MB",
      outcome->run_now, outcome->run_now == 1 ? "" : "s", outcome->wall_s, rate,
      outcome->attempts.repeated, static_cast<double>(outcome->attempts.peak_world_bytes) / 1e6);
  text += kept ? "; report in " + command.out + '\n' : "\n";
  auto json = batch_json(outcome->batch);
  json.erase("episodes");
  json["run_now"] = outcome->run_now;
  json["wall_s"] = outcome->wall_s;
  json["repeated_attempts"] = outcome->attempts.repeated;
  json["peak_world_mb"] = static_cast<double>(outcome->attempts.peak_world_bytes) / 1e6;
  console.show(text, json);
  if (outcome->given_up.empty()) return std::move(outcome->batch);
  const auto& [seed, why] = outcome->given_up.front();
  return failed(FailureKind::kCheck, fmt::format("{} seeds could not be run; seed {}: {}",
                                                 outcome->given_up.size(), seed, why));
}

Outcome<void> run_command(const BatchCommand& command, Console& console) {
  const auto done = run_and_show(command, /*kept=*/true, console);
  if (!done) return tl::unexpected(done.error());
  return {};
}

Outcome<void> run_command(const MergeCommand& command, Console& console) {
  std::vector<Batch> batches;
  for (const std::string& directory : command.directories) {
    auto batch = BatchDirectory(directory).read();
    if (!batch) return tl::unexpected(batch.error());
    batches.push_back(std::move(*batch));
  }
  auto merged = merge(batches, command.directories);
  if (!merged) return tl::unexpected(merged.error());
  BatchDirectory out(command.out);
  const auto begun = out.begin(merged->identity, merged->seeds);
  if (!begun) return tl::unexpected(begun.error());
  for (const auto& [seed, episode] : merged->episodes) {
    if (auto kept = out.keep(episode); !kept) return kept;
  }
  // The worst seeds of the whole batch keep their journals.
  std::vector<std::uint64_t> journals;
  for (const std::uint64_t seed : worst_seeds(*merged, command.journals)) {
    if (!std::ranges::binary_search(merged->journals, seed)) continue;
    for (std::size_t i = 0; i < batches.size(); ++i) {
      const auto from = BatchDirectory(command.directories[i]).journal(seed);
      const auto to = out.journal(seed);
      std::error_code status;
      if (!std::filesystem::exists(from, status)) continue;
      std::filesystem::create_directories(std::filesystem::path(to).parent_path(), status);
      std::filesystem::copy_file(from, to, std::filesystem::copy_options::overwrite_existing,
                                 status);
      if (status) return failed(FailureKind::kUsage, "cannot write " + to);
      journals.push_back(seed);
      break;
    }
  }
  std::ranges::sort(journals);
  merged->journals = std::move(journals);
  if (auto written = write_report(*merged, out); !written) return written;
  auto json = batch_json(*merged);
  json.erase("episodes");
  console.show(batch_table(*merged), json);
  return {};
}

Outcome<void> run_command(const ReportDiffCommand& command, Console& console) {
  const auto before = read_report(command.before), after = read_report(command.after);
  for (const auto* report : {&before, &after}) {
    if (!*report) return tl::unexpected(report->error());
  }
  const auto difference = compare(*before, *after, command.level);
  console.show(difference_table(difference), difference_json(difference));
  if (!difference.is_regression()) return {};
  return failed(FailureKind::kCheck, command.after + " is worse than " + command.before);
}

namespace {

void add_seeds(CLI::App& batch, BatchCommand& command) {
  batch
      .add_option_function<std::string>(
          "--seeds",
          [&command](const std::string& text) {
            auto seeds = parse_seeds(text);
            if (!seeds) {
              throw CLI::ValidationError("--seeds", "found " + text +
                                                        ", expected seeds as in 1..1000 or "
                                                        "1..10,20, at most a million");
            }
            command.seeds = std::move(*seeds);
          },
          "Seeds, as in 1..1000 or 1..10,20")
      ->type_name("SEEDS")
      ->required();
  batch
      .add_option_function<std::string>(
          "--shard",
          [&command](const std::string& text) {
            const auto shard = parse_shard(text);
            if (!shard) {
              throw CLI::ValidationError(
                  "--shard", "found " + text + ", expected I/N with I from 0 and below N");
            }
            command.shard = *shard;
          },
          "Run shard I (from 0) of N: every N-th seed from the I-th on")
      ->type_name("I/N");
}

void add_batch_run(CLI::App& app, CommandLine& line) {
  auto [batch, command] =
      add_command<BatchCommand>(app, line, "batch",
                                "Run a scenario with many seeds in virtual time, in "
                                "parallel, and write one report; finished runs are "
                                "not repeated");
  batch->add_option("NAME", command->scenario, "Name of a shipped scenario, or a file")
      ->required()
      ->check(not_empty());
  add_seeds(*batch, *command);
  command->jobs = std::max(1U, std::thread::hardware_concurrency());
  batch->add_option("--jobs", command->jobs, "Parallel runs (default: number of processors)")
      ->type_name("J")
      ->check(CLI::Range(1, 256));
  batch->add_option("--out", command->out, "Directory of the results")
      ->type_name("DIR")
      ->required()
      ->check(not_empty());
  batch
      ->add_option("--tries", command->tries,
                   "Attempts per seed if the daemon or controller crashes (default 3)")
      ->type_name("N")
      ->check(CLI::Range(1, 100));
  batch
      ->add_option("--journals", command->journals,
                   "Rerun the N worst seeds to record their journals (default 3)")
      ->type_name("N")
      ->check(CLI::Range(0, 1000));
  CLI::Option* controller =
      batch
          ->add_option("--controller", command->controller,
                       "Shell command of the controller (default: the scenario's program)")
          ->type_name("CMD")
          ->check(not_empty());
  batch
      ->add_flag("--reuse-controller", command->reuse_controller,
                 "Reuse the controller for one job after the other, as the default program allows")
      ->needs(controller);
  add_patience(*batch, command->patience_s);
  offer_json(*batch, line, "Print the report as one JSON object, without the single runs");
}

void add_merge(CLI::App& app, CommandLine& line) {
  auto [merge, merging] =
      add_command<MergeCommand>(app, line, "merge", "Merge the shards of a batch into one report");
  merge->add_option("DIR", merging->directories, "Directories of shards")
      ->required()
      ->check(not_empty());
  merge->add_option("--out", merging->out, "Directory of the whole batch")
      ->type_name("DIR")
      ->required()
      ->check(not_empty());
  merge
      ->add_option("--journals", merging->journals,
                   "Keep the journals of the N worst seeds, as given to batch (default 3)")
      ->type_name("N")
      ->check(CLI::Range(0, 1000));
  offer_json(*merge, line, "Print the report as one JSON object, without the single runs");
}

void add_report(CLI::App& app, CommandLine& line) {
  CLI::App* report = app.add_subcommand("report", "Compare batch reports");
  report->require_subcommand(1);
  auto [diff, comparing] = add_command<ReportDiffCommand>(
      *report, line, "diff",
      "Compare two reports with a significance test for each outcome; exit code 1 if the "
      "second is worse");
  diff->add_option("BEFORE", comparing->before,
                   "Reference: directory of a batch, or its report.json")
      ->required()
      ->check(not_empty());
  diff->add_option("AFTER", comparing->after, "Report that is tested for regressions")
      ->required()
      ->check(not_empty());
  diff->add_option("--level", comparing->level,
                   "Significance level, adjusted for all outcomes (default 0.05)")
      ->type_name("P")
      ->check(within(1e-9, 0.5));
  offer_json(*diff, line);
}

}  // namespace

void add_batch(CLI::App& app, CommandLine& line) {
  add_batch_run(app, line);
  add_merge(app, line);
  add_report(app, line);
}

}  // namespace aprsim::client
