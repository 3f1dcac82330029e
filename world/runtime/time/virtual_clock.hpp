#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "world/api/ports/virtual_time.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/runtime/time/time_barrier.hpp"

namespace aprsim::world {

struct VirtualTimeOptions {
  SimTime poll_period = std::chrono::milliseconds(25);  ///< at least one step
  std::vector<std::string> pacers;                      ///< declared; see TimeBarrier
  std::chrono::nanoseconds grace = std::chrono::seconds(5);
};

/// Shares the TimeBarrier between the listeners' threads and the simulation thread. The lock is
/// held for a query or a change, and while members are notified, which posts and does not wait.
class VirtualClock final : public api::VirtualTime {
 public:
  /// `wake` is called without the lock when time may go on. Thread: any.
  VirtualClock(VirtualTimeOptions options, SimTime step, std::function<void()> wake);

  [[nodiscard]] SimTime poll_period() const override { return poll_period_; }
  [[nodiscard]] bool is_registered(const std::string& role) const override;
  [[nodiscard]] std::optional<api::PacerId> join(api::PacerRole role,
                                                 std::function<void()> reached) override;
  void request_until(api::PacerId pacer, SimTime span) override;
  void finish(api::PacerId pacer) override;
  void leave(api::PacerId pacer) override;
  void exclude(api::PacerId pacer) override;

  // Thread: sim.

  struct Turn {
    bool paced = false;          ///< by clients; else by the wall clock
    TimeBarrier::Steps due = 0;  ///< steps that may be taken, while paced
    api::VirtualTimeStatePtr state;
  };
  [[nodiscard]] Turn turn(WallTime now);
  /// The robots of the cell, before its first snapshot is published.
  void set_robots(const std::vector<std::string>& robots, WallTime now);
  /// Endpoints whose commands wait until time goes on, in no order.
  [[nodiscard]] std::vector<api::EndpointId> endpoints() const;
  /// One step has been taken, and its snapshot is about to be published: a request made on seeing
  /// that snapshot counts from this step. No member is notified before published().
  void stepped();
  /// Whether time may go on at once.
  bool published(const api::Snapshot& snapshot, WallTime now);
  /// Notifies every waiting client: the cell is paused.
  void release_clients(WallTime now);

 private:
  struct Feed {
    int robot = 0;
    std::uint64_t epoch = 0, number = 0;  ///< of the latest frame
  };

  /// Notifies the members whose requests are met.
  void release_reached(WallTime now);
  void notify(const std::vector<api::PacerId>& reached);

  const SimTime poll_period_, step_;
  const std::function<void()> wake_;
  mutable std::mutex mutex_;
  TimeBarrier barrier_;
  std::map<api::PacerId, std::function<void()>> reached_;
  std::map<api::PacerId, Feed> feeds_;
  api::VirtualTimeStatePtr state_;
  bool publishing_ = false;  ///< between stepped() and published()
};

}  // namespace aprsim::world
