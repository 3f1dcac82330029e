#include <algorithm>
#include <filesystem>
#include <iostream>
#include <ostream>
#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/batch/batch_report.hpp"
#include "clients/aprsim/batch/report_diff.hpp"
#include "clients/aprsim/batch/run_batch.hpp"
#include "clients/aprsim/commands.hpp"

namespace aprsim::client {

Outcome<void> run_command(const BatchCommand& command, Console& console) {
  const auto outcome = run_batch({.scenario = command.scenario,
                                  .seeds = share_of(command.seeds, command.shard),
                                  .directory = command.out,
                                  .jobs = command.jobs,
                                  .tries = command.tries,
                                  .journals = command.journals,
                                  .controller = command.controller,
                                  .again = command.again},
                                 console.json ? nullptr : &std::cerr, isatty(STDERR_FILENO) == 1);
  if (!outcome) return tl::unexpected(outcome.error());
  const double rate = static_cast<double>(outcome->run_now) / std::max(1e-3, outcome->wall_s);
  std::string text = batch_table(outcome->batch);
  text += fmt::format(
      "\n{} episodes in {:.1f} s: {:.2f} a second; {} tried again; a world takes {:.0f} "
      "MB at most; report in {}\n",
      outcome->run_now, outcome->wall_s, rate, outcome->attempts.again,
      static_cast<double>(outcome->attempts.peak_world_bytes) / 1e6, command.out);
  auto json = batch_json(outcome->batch);
  json.erase("each");
  json["run_now"] = outcome->run_now;
  json["wall_s"] = outcome->wall_s;
  json["tried_again"] = outcome->attempts.again;
  json["peak_world_mb"] = static_cast<double>(outcome->attempts.peak_world_bytes) / 1e6;
  console.show(text, json);
  if (outcome->given_up.empty()) return {};
  const auto& [seed, why] = outcome->given_up.front();
  return failed(FailureKind::kCheck, fmt::format("{} seeds could not be run; seed {}: {}",
                                                 outcome->given_up.size(), seed, why));
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
  // Journals of those that are among the worst of all.
  std::vector<std::uint64_t> journals;
  for (const WorstEpisode& worst : worst_of(*merged, command.journals)) {
    for (std::size_t i = 0; worst.journal && i < batches.size(); ++i) {
      const auto from = BatchDirectory(command.directories[i]).journal(worst.seed);
      const auto to = out.journal(worst.seed);
      std::error_code status;
      if (!std::filesystem::exists(from, status)) continue;
      std::filesystem::create_directories(std::filesystem::path(to).parent_path(), status);
      std::filesystem::copy_file(from, to, std::filesystem::copy_options::overwrite_existing,
                                 status);
      if (status) return failed(FailureKind::kUsage, "cannot write " + to);
      journals.push_back(worst.seed);
      break;
    }
  }
  std::ranges::sort(journals);
  merged->journals = std::move(journals);
  if (auto written = write_report(*merged, out); !written) return written;
  auto json = batch_json(*merged);
  json.erase("each");
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

}  // namespace aprsim::client
