#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <boost/asio/any_io_executor.hpp>

#include "world/api/ports/virtual_time.hpp"

namespace aprsim::protocols {

/// A listener's or connection's participation in virtual time: it requests a span of simulated time
/// and continues on its own thread when that has passed. Thread: the executor's.
class TimePacer {
 public:
  /// `time` outlives it; null = the wall clock passes time, and join() has no effect.
  TimePacer(api::VirtualTime* time, boost::asio::any_io_executor io);
  ~TimePacer() { leave(); }
  TimePacer(const TimePacer&) = delete;
  TimePacer& operator=(const TimePacer&) = delete;

  /// Whether pacers of that role are declared.
  [[nodiscard]] bool is_registered(const std::string& role) const;
  /// Joins, unless it has joined before or all places of the role are taken.
  void join(api::PacerRole role);
  [[nodiscard]] bool joined() const { return id_.has_value(); }

  // While it has joined:

  /// Simulated time that one request takes.
  [[nodiscard]] SimTime poll_period() const { return time_->poll_period(); }
  /// Posts `then` once `span` has passed, unless it has been cancelled or has left before.
  void after(SimTime span, std::function<void()> then);
  /// Whether a continuation waits for its time.
  [[nodiscard]] bool waiting() const { return *then_ != nullptr; }
  /// Drops the continuation; the requested instant stays.
  void cancel() { *then_ = nullptr; }

  // No effect where it has not joined:

  /// The client may be gone, so time stops waiting for it.
  void finish();
  void leave();
  /// As leave(), and it may not join again for a while.
  void exclude();

 private:
  void detach();

  api::VirtualTime* time_;
  boost::asio::any_io_executor io_;
  std::optional<api::PacerId> id_;
  /// The continuation. Each join() has its own object, so that late calls find nothing.
  std::shared_ptr<std::function<void()>> then_ = std::make_shared<std::function<void()>>();
};

}  // namespace aprsim::protocols
