#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/aprsim/batch/batch_directory.hpp"
#include "clients/aprsim/batch/seeds.hpp"
#include "clients/aprsim/commands/command_group.hpp"

/// Commands for batches and their reports.
namespace aprsim::client {

/// Runs a scenario with many seeds in virtual time.
struct BatchCommand {
  std::string scenario;  ///< name or file
  std::vector<std::uint64_t> seeds;
  Shard shard;
  std::string out;  ///< directory
  unsigned jobs = 1;
  unsigned tries = 3;
  unsigned journals = 3;
  std::string controller;         ///< empty = the scenario's program
  bool reuse_controller = false;  ///< it takes one job after the other
  unsigned patience_s = 600;      ///< of wall time without progress
};
/// Merges the shards of a batch.
struct MergeCommand {
  std::vector<std::string> directories;
  std::string out;
  unsigned journals = 3;  ///< of the worst seeds, as in the shards
};
/// Compares two batch reports.
struct ReportDiffCommand {
  std::string before, after;  ///< directories, or files of reports
  double level = 0.05;        ///< of significance
};

/// Runs a batch and shows its report; `kept`: whether its directory stays.
[[nodiscard]] Outcome<Batch> run_and_show(const BatchCommand& command, bool kept, Console& console);
[[nodiscard]] Outcome<void> run_command(const BatchCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const MergeCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ReportDiffCommand& command, Console& console);

/// Their words and options.
void add_batch(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
