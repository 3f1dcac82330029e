#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "aprsim/v1/web.pb.h"
#include "world/api/ports/ports.hpp"

namespace aprsim::web {

/// Moves one robot by hand, never faster than manual_mode.hpp says. A jog that is held moves it as
/// long as its viewer keeps asking: a dead man's switch that holds here, not in the browser. Steps
/// move it by a set way each, one after the other. Every motion begins at rest. Whoever jogs keeps
/// the robot until the jog ends; a command from another wire ends it without a stop of ours.
/// Thread: the server's.
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
  /// Makes a step after those that are not made yet; its outcome, under the request's `id`, is
  /// among take_ended(). Errors: as of renew(), and step; kUnavailable when too many wait.
  [[nodiscard]] Result<void> step(Viewer viewer, std::uint32_t id, const v1::JogRequest& request,
                                  const api::Snapshot& snapshot);
  /// Stops the robot if this viewer jogs it.
  void release(Viewer viewer);
  /// Notices timeouts, ends of stretches and steps, commands from elsewhere. Call it often.
  void tick(const api::Snapshot& snapshot, Clock::time_point now);

  /// A step that has come to its end, and how.
  struct EndedStep {
    Viewer viewer = 0;
    std::uint32_t id = 0;
    Result<void> outcome;
  };
  /// Those since the last call, in their order.
  [[nodiscard]] std::vector<EndedStep> take_ended() { return std::exchange(ended_, {}); }

  [[nodiscard]] bool active() const { return jog_.has_value(); }
  /// Whether the jog under way, or the last one, has sent this command. The robot may refuse such a
  /// one: then a shorter stretch follows, and in the end who jogs is told.
  [[nodiscard]] bool sent(api::Ticket ticket) const {
    return first_ <= ticket && ticket <= ticket_;
  }

 private:
  struct Jog {
    Viewer viewer = 0;
    v1::JogRequest wanted;
    std::string request;        // serialised, to notice a change; empty for steps
    Clock::time_point expires;  // unless renewed; not for steps
    std::uint64_t epoch = 0;
    bool begun = false;   // else it waits for the robot to come to rest
    double stretch = 0;   // of the way asked for last [m or rad]
    std::string blocked;  // not empty: goes no further, and why
    /// Obeys a command from elsewhere, or has been stopped by a fault and may be backing off: there
    /// is nothing of ours to be stopped.
    bool lost = false;
  };
  struct Step {
    std::uint32_t id = 0;
    v1::JogRequest wanted;
  };

  [[nodiscard]] Result<void> check(const v1::JogRequest& request,
                                   const api::Snapshot& snapshot) const;
  /// Begins `jog`, at once if the robot is at rest.
  [[nodiscard]] Result<void> start(Jog jog, const api::Snapshot& snapshot);
  [[nodiscard]] Result<void> begin(const api::Snapshot& snapshot);
  void begin_at_rest(const api::Snapshot& snapshot);
  [[nodiscard]] Result<void> move_joint(const api::Snapshot& snapshot);
  [[nodiscard]] Result<void> move_tool(const api::Snapshot& snapshot);
  void proceed(const api::Snapshot& snapshot);
  void proceed_with_steps(const api::Snapshot& snapshot);
  void end_step(const Result<void>& outcome);
  /// Ends the jog; the steps that are not made fail with `why`.
  void finish(const std::string& why);
  void stop(const std::string& why);
  /// Makes the robot ready again if it has refused the stretch that was given up.
  void forgive_refusal(const api::Snapshot& snapshot);
  [[nodiscard]] Result<void> submit(const api::RobotAction& action);

  int robot_;
  api::EndpointId endpoint_;
  api::CommandSink& sink_;
  std::chrono::milliseconds timeout_;
  std::optional<Jog> jog_;
  std::deque<Step> steps_;  // of jog_; the first is being made
  std::vector<EndedStep> ended_;
  api::Ticket first_ = 1, ticket_ = 0;  // of the commands of a jog, and the last of ours
  bool stop_owed_ = false;              // the queue was full
  /// Epoch of a line that was given up: the robot may have refused its last stretch meanwhile.
  std::optional<std::uint64_t> given_up_;
};

}  // namespace aprsim::web
