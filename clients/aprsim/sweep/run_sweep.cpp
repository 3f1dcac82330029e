#include "clients/aprsim/sweep/run_sweep.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/interruption.hpp"
#include "clients/aprsim/sweep/sweep_report.hpp"
#include "clients/process/child_process.hpp"
#include "world/scenario/scenario_reader.hpp"

namespace aprsim::client {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using process::ChildProcess;

/// A process with one seed.
struct Job {
  std::uint64_t seed = 0;
  fs::path directory;
  ChildProcess process;
};

Outcome<Job> start_job(const ScenarioRunCommand& command, std::uint64_t seed,
                       const fs::path& directory) {
  std::error_code status;
  fs::create_directories(directory, status);
  std::vector<std::string> arguments{fs::read_symlink("/proc/self/exe", status).string(),
                                     "scenario",
                                     "run",
                                     command.name,
                                     "--virtual",
                                     "--seed",
                                     std::to_string(seed),
                                     "--report",
                                     directory.string()};
  if (!command.controller.empty()) {
    arguments.insert(arguments.end(), {"--controller", command.controller});
  }
  auto process = ChildProcess::start(arguments, {}, (directory / "run.log").string(),
                                     ChildProcess::Pipes::kNone);
  if (!process) return failed(FailureKind::kUsage, process.error().message);
  return Job{seed, directory, std::move(*process)};
}

/// What it has left; without a report, what it said last.
SweepRun result_of(const Job& job) {
  SweepRun out{.seed = job.seed};
  std::ifstream file(job.directory / "report.json");
  const auto report = nlohmann::json::parse(file, nullptr, /*allow_exceptions=*/false);
  if (!report.is_object()) {
    std::ifstream log(job.directory / "run.log");
    std::string last = "it left no report";
    for (std::string line; std::getline(log, line);) {
      if (!line.empty()) last = line;
    }
    out.failure = last;
    return out;
  }
  out.as_expected = report.value("as_expected", false);
  out.ended = report.value("ended", "");
  out.state_hash = report.value("state_hash", "");
  for (const auto& [measure, value] : report["measures"].items()) {
    if (value.is_number()) out.values[measure] = value;
  }
  return out;
}

Outcome<void> write(const fs::path& file, const std::string& text) {
  std::ofstream out(file);
  if (out << text << std::flush) return {};
  return failed(FailureKind::kUsage, "cannot write " + file.string());
}

/// All of them, at most `jobs` at once.
Outcome<Sweep> run_all(const ScenarioRunCommand& command, const fs::path& directory,
                       Console& console) {
  const interruption::Hold hold;
  Sweep sweep{.scenario = command.name};
  std::vector<Job> running;
  for (std::uint64_t next = 0; next < *command.repeat || !running.empty();) {
    if (interruption::noted()) {
      for (Job& job : running) job.process.stop(20s);
      return failed(FailureKind::kInterrupted, "interrupted");
    }
    if (next < *command.repeat && running.size() < command.jobs) {
      const std::uint64_t seed = command.seed + next++;
      auto job = start_job(command, seed, directory / fmt::format("seed_{}", seed));
      if (!job) return tl::unexpected(job.error());
      running.push_back(std::move(*job));
      continue;
    }
    std::vector<Job> going;
    for (Job& job : running) {
      if (!job.process.ended()) {
        going.push_back(std::move(job));
        continue;
      }
      sweep.runs.push_back(result_of(job));
      const SweepRun& run = sweep.runs.back();
      if (!console.json) {
        std::cerr << fmt::format("seed {}: {}\n", run.seed, run.failure ? *run.failure : run.ended)
                  << std::flush;
      }
    }
    running = std::move(going);
    interruption::sleep_until(std::chrono::steady_clock::now() + 20ms);
  }
  return sweep;
}

}  // namespace

Outcome<void> run_sweep(const ScenarioRunCommand& command, Console& console) {
  const auto scenario = scenario::load_scenario(command.name, scene::default_data_paths());
  if (!scenario) return failed(FailureKind::kUsage, scenario.error().message);
  fs::path directory = command.report;
  std::error_code ignored;
  if (command.report.empty()) {
    std::string name = (fs::temp_directory_path(ignored) / "aprsim-sweep-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) {
      return failed(FailureKind::kUsage, "cannot make a directory " + name);
    }
    directory = name;
  }
  auto sweep = run_all(command, directory, console);
  if (command.report.empty()) fs::remove_all(directory, ignored);
  if (!sweep) return tl::unexpected(sweep.error());
  sweep->scenario = scenario->name;
  const auto json = sweep_json(*sweep);
  const std::string table = sweep_table(*sweep);
  console.show(table, json);
  if (!command.report.empty()) {
    if (auto ok = write(directory / "sweep.json", json.dump(1) + '\n'); !ok) return ok;
    if (auto ok = write(directory / "sweep.txt", table); !ok) return ok;
  }
  const auto good = [](const SweepRun& run) { return !run.failure && run.as_expected; };
  if (std::ranges::all_of(sweep->runs, good)) return {};
  return failed(
      FailureKind::kCheck,
      fmt::format("{} of {} runs were not as expected",
                  std::ranges::count_if(sweep->runs, std::not_fn(good)), sweep->runs.size()));
}

}  // namespace aprsim::client
