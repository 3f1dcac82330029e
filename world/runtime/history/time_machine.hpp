#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "world/api/ports/history.hpp"
#include "world/api/ports/ports.hpp"
#include "world/cell/world.hpp"
#include "world/runtime/history/bookmarks.hpp"
#include "world/runtime/history/history_records.hpp"
#include "world/runtime/history/past_states.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::world {

/// Computes past moments of a run in a world of its own, on its own thread of low priority: queries
/// of the past do not slow the running cell.
class TimeMachine final : public api::History {
 public:
  /// Moments that may wait to be computed at once.
  static constexpr std::size_t kMaxWaiting = 64;

  /// `max_state_bytes`: limit of the states cached for nearby queries. `run`: progress of the run;
  /// null = that of the records. All outlive the machine.
  TimeMachine(std::shared_ptr<const scene::Scene> scene, HistoryRecords& records,
              Bookmarks& bookmarks, const api::SnapshotSource* run,
              std::uint64_t max_state_bytes = std::uint64_t{48} << 20);
  ~TimeMachine() override;
  TimeMachine(const TimeMachine&) = delete;
  TimeMachine& operator=(const TimeMachine&) = delete;

  [[nodiscard]] std::vector<api::HistorySpan> spans() const override;
  void ask(api::Moment moment, Answer answer) override;
  [[nodiscard]] std::vector<api::Bookmark> bookmarks() const override;
  [[nodiscard]] std::uint64_t bookmark_revision() const override { return bookmarks_.revision(); }
  [[nodiscard]] Result<api::Bookmark> add_bookmark(api::Moment moment, std::string text) override;
  [[nodiscard]] Result<void> remove_bookmark(std::uint64_t id) override {
    return bookmarks_.remove(id);
  }

  /// Memory of the cached states. Thread: any.
  [[nodiscard]] std::uint64_t state_bytes() const { return states_.bytes(); }

  /// Answers waiting requests with kUnavailable and ends the thread; may be called twice. Thread:
  /// not the machine's.
  void stop();

 private:
  struct Asked {
    api::Moment moment;
    Answer answer;
  };

  void catch_up() const;
  [[nodiscard]] SimTime time_of(std::uint64_t step) const;
  // ---- Thread: the machine's
  void run(const std::stop_token& stop);
  [[nodiscard]] Result<api::PastMoment> work_out(api::Moment moment, const std::stop_token& stop);
  void begin_at(const PastCourse& course, api::Moment moment);
  void put(api::Moment moment, const WorldState& state);
  [[nodiscard]] std::shared_ptr<const WorldState> keep_state();

  std::shared_ptr<const scene::Scene> scene_;
  HistoryRecords& records_;
  Bookmarks& bookmarks_;
  const api::SnapshotSource* run_;
  SimTime step_size_;

  // The machine's own: the world is after step `at_`, as the run was then.
  std::unique_ptr<World> world_;
  std::optional<api::Moment> at_;
  PastStates states_;

  std::mutex mutex_;
  std::condition_variable_any asked_for_;
  std::deque<Asked> asked_;
  bool ended_ = false;
  std::jthread thread_;  // ends first
};

}  // namespace aprsim::world
