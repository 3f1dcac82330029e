#include "clients/aprsim/batch/run_batch.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "clients/aprsim/batch/batch_report.hpp"
#include "clients/aprsim/batch/batch_results.hpp"
#include "clients/aprsim/cli/interruption.hpp"
#include "clients/aprsim/scenario/batch_worker.hpp"
#include "world/base/utf8.hpp"
#include "world/scenario/plan.hpp"
#include "world/scenario/scenario_reader.hpp"

namespace aprsim::client {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using SteadyClock = std::chrono::steady_clock;

constexpr auto kReportPeriod = 5s;  // least time between two reports
constexpr int kReportShare = 20;    // reports take at most one part in so many of the time
constexpr auto kBarPeriod = 200ms;  // of a bar that is updated in place
constexpr auto kLinePeriod = 10s;   // of single lines
constexpr std::size_t kBarLength = 24;

double seconds(SteadyClock::duration span) { return std::chrono::duration<double>(span).count(); }

std::string fingerprint_of(const scenario::Scenario& scenario) {
  std::ifstream file(scenario.file, std::ios::binary);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  std::uint64_t hash = 0xcbf29ce484222325U;  // FNV-1a
  for (const std::string* part : {&text, &scenario.scene_text}) {
    for (const char c : *part) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  }
  return fmt::format("{:016x}", hash);
}

struct Task {
  std::uint64_t seed = 0;
  unsigned tries = 0;  ///< so far
};

/// The remaining seeds and the results, shared by the workers. Thread: any.
class Work {
 public:
  Work(BatchDirectory& directory, Batch batch, const BatchOptions& options)
      : directory_(directory), batch_(std::move(batch)), most_tries_(options.tries) {
    for (const std::uint64_t seed : options.seeds) {
      if (!batch_.episodes.contains(seed)) tasks_.push_back({seed});
    }
    wanted_ = tasks_.size();
  }

  /// The next seed; absent when all are done or an end is requested.
  std::optional<Task> next() {
    std::unique_lock lock(mutex_);
    // Another worker may return its seed.
    changed_.wait(lock, [&] { return !tasks_.empty() || under_way_ == 0 || ending_; });
    if (tasks_.empty() || ending_) return std::nullopt;
    const Task task = tasks_.front();
    tasks_.pop_front();
    ++under_way_;
    return task;
  }

  void done(const Episode& episode, std::uint64_t peak_bytes) {
    const std::lock_guard lock(mutex_);
    --under_way_;
    attempts_.peak_world_bytes = std::max(attempts_.peak_world_bytes, peak_bytes);
    if (auto kept = directory_.keep(episode); !kept) {
      end(kept.error());
      return;
    }
    batch_.episodes.insert_or_assign(episode.seed, episode);
    ++finished_;
    changed_.notify_all();
  }

  void failed(Task task, const Failure& failure) {
    const std::lock_guard lock(mutex_);
    --under_way_;
    if (failure.kind == FailureKind::kInterrupted) {
      end(failure);
      return;
    }
    attempts_.last_causes.emplace_back(task.seed, failure.message);
    if (++task.tries < most_tries_ && failure.kind != FailureKind::kUsage) {
      ++attempts_.repeated;
      tasks_.push_back(task);
    } else {
      given_up_.emplace_back(task.seed, failure.message);
    }
    static_cast<void>(directory_.keep(attempts_));
    changed_.notify_all();
  }

  void stop() {
    const std::lock_guard lock(mutex_);
    ending_ = true;
    changed_.notify_all();
  }

  struct View {
    std::size_t finished = 0, wanted = 0, given_up = 0;
    std::uint64_t repeated = 0;
    bool over = false;
  };
  [[nodiscard]] View view() {
    const std::lock_guard lock(mutex_);
    return {finished_, wanted_, given_up_.size(), attempts_.repeated,
            ending_ || (tasks_.empty() && under_way_ == 0)};
  }
  [[nodiscard]] Batch batch() {
    const std::lock_guard lock(mutex_);
    return batch_;
  }
  /// Call after the last worker has ended.
  BatchOutcome result() {
    return {.batch = std::move(batch_),
            .attempts = std::move(attempts_),
            .run_now = finished_,
            .given_up = std::move(given_up_)};
  }
  [[nodiscard]] const std::optional<Failure>& failure() const { return failure_; }

 private:
  void end(const Failure& failure) {
    if (!failure_) failure_ = failure;
    ending_ = true;
    changed_.notify_all();
  }

  BatchDirectory& directory_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Task> tasks_;
  std::size_t under_way_ = 0, finished_ = 0, wanted_ = 0;
  Batch batch_;
  Attempts attempts_;
  std::vector<std::pair<std::uint64_t, std::string>> given_up_;
  std::optional<Failure> failure_;
  bool ending_ = false;
  const unsigned most_tries_;
};

/// Runs one seed after the other with the same programs.
void work_off(const scenario::Scenario& scenario, const BatchOptions& options, unsigned number,
              Work& work) {
  BatchWorker worker(
      scenario,
      {.controller = options.controller,
       .reuse_controller = options.reuse_controller,
       .directory = (fs::path(options.directory) / "stations" / std::to_string(number)).string(),
       .patience = options.patience});
  const auto paths = scene::default_data_paths();
  while (const auto task = work.next()) {
    const auto plan = scenario::plan(scenario, task->seed, paths);
    if (!plan) {
      work.failed(*task, {FailureKind::kUsage, plan.error().message});
      continue;
    }
    const auto run = worker.run(*plan, {});
    if (run) {
      work.done(episode_of(*run, *plan), worker.peak_bytes());
    } else {
      work.failed(*task, run.error());
    }
  }
}

/// Shows the progress of a batch.
class Progress {
 public:
  /// Short batches show none unless in place.
  Progress(std::ostream* out, bool in_place)
      : out_(out), in_place_(in_place), due_(began_ + (in_place ? 0s : kLinePeriod)) {}

  void show(const Work::View& view, bool last) {
    const auto now = SteadyClock::now();
    if (out_ == nullptr || (last ? !in_place_ : now < due_)) return;
    due_ = now + (in_place_ ? SteadyClock::duration(kBarPeriod) : kLinePeriod);
    const double share =
        view.wanted == 0 ? 1
                         : static_cast<double>(view.finished) / static_cast<double>(view.wanted);
    const double rate = static_cast<double>(view.finished) / std::max(1e-3, seconds(now - began_));
    std::string text;
    if (in_place_) {
      const auto full = static_cast<std::size_t>(share * kBarLength);
      text = "\r[" + std::string(full, '#') + std::string(kBarLength - full, ' ') + "] ";
    }
    text += fmt::format("{} of {}, {:.2f} a second", view.finished, view.wanted, rate);
    if (view.finished > 0 && view.finished < view.wanted) {
      const auto left_s = static_cast<long>(
          static_cast<double>(view.wanted - view.finished) / std::max(1e-9, rate) + 0.5);
      text += fmt::format(", {}:{:02} left", left_s / 60, left_s % 60);
    }
    if (view.repeated > 0) text += fmt::format(", {} repeated", view.repeated);
    if (view.given_up > 0) text += fmt::format(", {} given up", view.given_up);
    *out_ << text << (in_place_ ? (last ? "\033[K\n" : "\033[K") : "\n") << std::flush;
  }

 private:
  std::ostream* out_;
  bool in_place_;
  SteadyClock::time_point began_ = SteadyClock::now();
  SteadyClock::time_point due_;
};

/// Reruns the worst seeds to record their journals. A rerun with another final state is a failure.
Outcome<void> make_journals(const scenario::Scenario& scenario, const BatchOptions& options,
                            const BatchDirectory& directory, BatchOutcome& outcome) {
  const auto paths = scene::default_data_paths();
  std::error_code status;
  fs::create_directories(directory.path() / "journals", status);
  for (const std::uint64_t seed : worst_seeds(outcome.batch, options.journals)) {
    if (std::ranges::binary_search(outcome.batch.journals, seed) || interruption::requested())
      continue;
    const auto plan = scenario::plan(scenario, seed, paths);
    if (!plan) continue;
    const std::string journal = directory.journal(seed), part = journal + ".part";
    fs::remove(part, status);
    Outcome<RunResult> run;
    {
      BatchWorker worker(scenario, {.controller = options.controller,
                                    .reuse_controller = options.reuse_controller,
                                    .directory = (directory.path() / "stations/journal").string(),
                                    .journal = part,
                                    .patience = options.patience});
      run = worker.run(*plan, {});
    }
    if (!run) {
      outcome.attempts.last_causes.emplace_back(seed, "journal: " + run.error().message);
      continue;
    }
    if (run->state_hash != outcome.batch.episodes.at(seed).state_hash) {
      return failed(FailureKind::kCheck,
                    fmt::format("seed {} ended in state {}, and in {} when it was rerun", seed,
                                outcome.batch.episodes.at(seed).state_hash, run->state_hash));
    }
    fs::rename(part, journal, status);
    if (status) return failed(FailureKind::kUsage, "cannot write " + journal);
    auto& journals = outcome.batch.journals;
    journals.insert(std::ranges::upper_bound(journals, seed), seed);
  }
  return {};
}

/// Runs the remaining seeds and rewrites the report every few seconds.
void run_workers(const scenario::Scenario& scenario, const BatchOptions& options,
                 BatchDirectory& directory, Work& work, Progress bar) {
  // Joins with the last worker.
  std::vector<std::jthread> workers;
  const std::size_t count = std::min<std::size_t>(options.jobs, work.view().wanted);
  for (unsigned number = 1; number <= count; ++number) {
    workers.emplace_back([&, number] { work_off(scenario, options, number, work); });
  }
  auto report_due = SteadyClock::now() + kReportPeriod;
  std::size_t reported = 0;
  while (!work.view().over) {
    interruption::sleep_until(SteadyClock::now() + 50ms);
    if (interruption::requested()) work.stop();
    bar.show(work.view(), false);
    const auto now = SteadyClock::now();
    if (now < report_due || work.view().finished == reported) continue;
    reported = work.view().finished;
    if (auto written = write_report(work.batch(), directory); !written) work.stop();
    const auto took = SteadyClock::now() - now;
    report_due =
        SteadyClock::now() + std::max<SteadyClock::duration>(kReportPeriod, kReportShare * took);
  }
  bar.show(work.view(), true);
}

}  // namespace

Outcome<BatchOutcome> run_batch(const BatchOptions& options, std::ostream* progress,
                                bool in_place) {
  const interruption::Hold hold;
  const auto began = SteadyClock::now();
  const auto scenario = scenario::load_scenario(options.scenario, scene::default_data_paths());
  if (!scenario) return failed(FailureKind::kUsage, scenario.error().message);
  BatchDirectory directory(options.directory);
  auto begun =
      directory.begin({.scenario = utf8::valid(scenario->name),
                       .description = utf8::valid(scenario->description),
                       .controller = options.controller.empty() ? scenario->program
                                                                : utf8::valid(options.controller),
                       .version = APRSIM_VERSION,
                       .fingerprint = fingerprint_of(*scenario)},
                      options.seeds);
  if (!begun) return tl::unexpected(begun.error());
  Work work(directory, std::move(*begun), options);
  run_workers(*scenario, options, directory, work, Progress(progress, in_place));
  const auto failure = work.failure();
  BatchOutcome outcome = work.result();
  if (interruption::happened() || (failure && failure->kind == FailureKind::kInterrupted)) {
    const interruption::Cleanup cleanup;
    static_cast<void>(write_report(outcome.batch, directory));
    return client::failed(FailureKind::kInterrupted,
                          fmt::format("interrupted; {} of {} seeds are done; repeat the command "
                                      "to continue",
                                      outcome.batch.episodes.size(), outcome.batch.seeds.size()));
  }
  if (failure) return tl::unexpected(*failure);
  if (auto made = make_journals(*scenario, options, directory, outcome); !made) {
    return tl::unexpected(made.error());
  }
  if (auto written = write_report(outcome.batch, directory); !written) {
    return tl::unexpected(written.error());
  }
  if (auto kept = directory.keep(outcome.attempts); !kept) return tl::unexpected(kept.error());
  // Only failed workers keep their logs.
  std::error_code ignored;
  if (outcome.given_up.empty()) fs::remove_all(directory.path() / "stations", ignored);
  outcome.wall_s = seconds(SteadyClock::now() - began);
  return outcome;
}

}  // namespace aprsim::client
