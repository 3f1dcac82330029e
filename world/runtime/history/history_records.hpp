#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "world/api/ports/history.hpp"
#include "world/runtime/record/recorder.hpp"

namespace aprsim::world {

/// Limits of the kept past; both apply.
struct HistoryLimits {
  std::uint64_t steps = 600'000;
  std::uint64_t bytes = std::uint64_t{128} << 20;  ///< of memory, approximately
  /// Steps between two checkpoints, fewer if commands fill the memory sooner. The world is stepped
  /// from a checkpoint to a moment after it. A multiple of kSampleSteps.
  std::uint64_t checkpoint_steps = 2000;
};

/// A command that took effect.
struct PastCommand {
  RunTime time;
  QueuedCommand command;
};

/// The course of a run up to a moment: a state at or before it, and the commands since, in order.
struct PastCourse {
  RunTime begin;
  std::shared_ptr<const WorldState> state;
  std::vector<std::shared_ptr<const PastCommand>> commands;  ///< before the moment
};

/// Keeps in memory the records from which the latest past of a run can be computed: states, and the
/// commands between them. The lock is held to copy pointers.
class HistoryRecords final : public Recorder {
 public:
  explicit HistoryRecords(HistoryLimits limits) : limits_(limits) {}

  // ---- Thread: sim
  void began(RunTime time, std::uint64_t seed, const std::string* loaded,
             const std::shared_ptr<const scene::Scene>& scene) override;
  void applied(RunTime time, const QueuedCommand& command, const Error* failure) override;
  void sampled(RunTime time, StateSample sample) override;
  void saved(RunTime time, std::uint64_t hash, std::shared_ptr<const WorldState> state) override;
  void stopped(RunTime time, const std::string& why) override;
  [[nodiscard]] bool wants_checkpoint() const override {
    return wants_checkpoint_.load(std::memory_order_relaxed);
  }

  // ---- Thread: any
  /// The run has reached at least this moment.
  void reach(RunTime time);
  /// Drops the older half of the records when the process runs short of memory.
  void drop_older_half();
  /// Times are not filled in.
  [[nodiscard]] std::vector<api::HistorySpan> spans() const;
  /// Null when the moment is not kept.
  [[nodiscard]] std::optional<PastCourse> course_to(api::Moment moment) const;
  [[nodiscard]] bool keeps(api::Moment moment) const;
  [[nodiscard]] std::uint64_t bytes() const;

 private:
  /// The part of a run from one state to the next.
  struct Segment {
    RunTime begin;
    std::shared_ptr<const WorldState> state;
    std::vector<std::shared_ptr<const PastCommand>> commands;
    std::uint64_t last_step = 0;
    std::uint64_t position = 0;                  ///< of `begin`, in steps of all epochs
    std::uint64_t bytes = 0, command_bytes = 0;  ///< of the segment, and of its commands
  };
  struct Epoch {
    std::uint64_t seed = 0;
    std::optional<std::string> loaded;
  };

  void grow(RunTime time);
  void trim();
  [[nodiscard]] const Segment* find(api::Moment moment) const;

  const HistoryLimits limits_;
  std::atomic<bool> wants_checkpoint_{false};
  mutable std::mutex mutex_;
  std::deque<Segment> segments_;  ///< ordered by begin
  std::map<std::uint64_t, Epoch> epochs_;
  std::uint64_t bytes_ = 0;
};

}  // namespace aprsim::world
