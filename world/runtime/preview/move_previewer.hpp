#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "world/api/commands/command.hpp"
#include "world/api/ports/move_previews.hpp"
#include "world/cell/world.hpp"

namespace aprsim::world {

/// A preview of a checked request, bound to a moment of the cell.
class BoundPreview {
 public:
  /// Copies of the world what it needs. Thread: the world's.
  BoundPreview(const World& world, std::uint64_t epoch, const api::PreviewRequest& request);
  /// Once. Errors: as of MovePreviews. Thread: any.
  [[nodiscard]] Result<api::MovePreview> make();
  /// Thread: any, beside make().
  void cancel() {
    if (move_) (*move_)->cancel();
  }

 private:
  api::MovePreview moment_;  ///< without the move
  Result<std::shared_ptr<robot::MovePreview>> move_;
};

/// Plans previews on a thread of its own, of low priority. The simulation thread only copies what a
/// plan is a function of.
class MovePreviewer final : public api::MovePreviews {
 public:
  /// Previews that may wait at once.
  static constexpr std::size_t kMaxWaiting = 16;

  struct Simulation {
    /// The check of commands. Thread: any.
    std::function<Result<void>(api::Command&)> check;
    /// Wakes the simulation thread, which then calls bind_next(). Thread: any.
    std::function<void()> notify;
  };

  explicit MovePreviewer(Simulation simulation);
  ~MovePreviewer() override;
  MovePreviewer(const MovePreviewer&) = delete;
  MovePreviewer& operator=(const MovePreviewer&) = delete;

  void ask(api::PreviewRequest request, Answer answer) override;

  /// Whether a request waits for bind_next(). Thread: any.
  [[nodiscard]] bool has_request() const { return requests_.load(std::memory_order_acquire) > 0; }
  /// Binds the first request that waits to the present state. Thread: sim, between two steps.
  void bind_next(const World& world, std::uint64_t epoch);

  /// Answers all requests with kUnavailable and ends the thread; may be called twice. Thread: not
  /// its own.
  void stop();

 private:
  struct Asked {
    api::PreviewRequest request;
    Answer answer;
  };
  struct Bound {
    std::shared_ptr<BoundPreview> preview;  ///< null = the cell could not be copied
    Answer answer;
  };
  void run(const std::stop_token& stop);

  const Simulation simulation_;
  std::mutex mutex_;
  std::condition_variable_any bound_one_;
  std::atomic<std::size_t> requests_{0};
  std::deque<Asked> asked_;
  std::deque<Bound> bound_;
  std::shared_ptr<BoundPreview> running_;
  bool ended_ = false;
  std::jthread thread_;  // ends first
};

}  // namespace aprsim::world
