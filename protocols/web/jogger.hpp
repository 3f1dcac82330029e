#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "aprsim/v1/web.pb.h"
#include "world/api/ports.hpp"

namespace aprsim::web {

/// Moves one robot as long as its viewer keeps asking: a dead man's switch that holds here, not in
/// the browser. Whoever jogs keeps the robot until the jog ends; a command from another wire ends
/// it without a stop of ours. Thread: the server's.
class Jogger {
 public:
  using Clock = std::chrono::steady_clock;
  using Viewer = std::uint64_t;

  Jogger(int robot, api::EndpointId endpoint, api::CommandSink& sink,
         std::chrono::milliseconds timeout)
      : robot_(robot), endpoint_(endpoint), sink_(sink), timeout_(timeout) {}

  /// Begins, changes or keeps going a jog. Errors: kInvalidArgument (joint, axis, speed),
  /// kFailedPrecondition (not ready, jogged by another viewer), kUnreachable with the robot's
  /// reason when it goes no further that way.
  [[nodiscard]] Result<void> renew(Viewer viewer, const v1::JogRequest& request,
                                   const api::Snapshot& snapshot, Clock::time_point now);
  /// Stops the robot if this viewer jogs it.
  void release(Viewer viewer);
  /// Notices timeouts, ends of stretches and commands from elsewhere. Call it often.
  void tick(const api::Snapshot& snapshot, Clock::time_point now);

  [[nodiscard]] bool active() const { return jog_.has_value(); }
  /// Whether the jog under way, or the last one, has sent this command. The robot may refuse such a
  /// one: then a shorter stretch follows, and in the end who jogs is told.
  [[nodiscard]] bool sent(api::Ticket ticket) const { return first_ <= ticket && ticket <= last_; }

 private:
  struct Jog {
    Viewer viewer = 0;
    std::string request;  // serialised, to notice a change
    v1::JogRequest wanted;
    Clock::time_point expires;
    std::uint64_t epoch = 0;
    api::Ticket ticket = 0;   // of the last command of ours
    api::LimitSetting limit;  // to be restored, for tool jogs
    double stretch = 0;       // of the way asked for last [m or rad]
    std::string blocked;      // not empty: goes no further, and why
    bool taken_over = false;  // by a command from elsewhere; does not begin again by itself
  };

  [[nodiscard]] Result<void> check(const v1::JogRequest& request,
                                   const api::Snapshot& snapshot) const;
  [[nodiscard]] Result<void> begin(const api::Snapshot& snapshot);
  [[nodiscard]] Result<void> move_joint(const api::Snapshot& snapshot);
  [[nodiscard]] Result<void> move_tool(const api::Snapshot& snapshot);
  void proceed(const api::Snapshot& snapshot);
  void stop();
  [[nodiscard]] Result<void> submit(const api::RobotAction& action);

  int robot_;
  api::EndpointId endpoint_;
  api::CommandSink& sink_;
  std::chrono::milliseconds timeout_;
  std::optional<Jog> jog_;
  api::Ticket first_ = 1, last_ = 0;  // of the commands of a jog
  bool stop_owed_ = false;            // the queue was full
};

}  // namespace aprsim::web
