#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "aprsim/v1/web.pb.h"
#include "world/api/ports/ports.hpp"

namespace aprsim::web {

/// Jogs one robot within the limits of manual_mode.hpp. A held jog lasts while its viewer renews
/// it: a dead man's switch in the daemon, not in the browser. Steps move the robot by a fixed
/// distance, one after the other. Every motion begins at rest. One viewer jogs a robot at a time. A
/// command from another client ends the jog without a stop. Thread: the server's.
class Jogger {
 public:
  using Clock = std::chrono::steady_clock;
  using Viewer = std::uint64_t;

  /// `cell`: where the robot has this index; null = in any. Other cells do not get its commands.
  Jogger(int robot, api::EndpointId endpoint, api::CommandSink& sink,
         std::chrono::milliseconds timeout,
         std::shared_ptr<const api::CellDescription> cell = nullptr)
      : robot_(robot),
        endpoint_(endpoint),
        sink_(sink),
        timeout_(timeout),
        cell_(std::move(cell)) {}

  /// Begins, changes or continues a jog. Errors: kInvalidArgument (joint, axis, speed),
  /// kFailedPrecondition (not ready, jogged by another viewer), kUnreachable with the robot's
  /// reason at the end of its reach.
  [[nodiscard]] Result<void> renew(Viewer viewer, const v1::JogRequest& request,
                                   const api::Snapshot& snapshot, Clock::time_point now);
  /// Queues a step; take_ended() returns its outcome under the request's `id`. Errors: as of
  /// renew(), and step; kUnavailable when too many wait.
  [[nodiscard]] Result<void> step(Viewer viewer, std::uint32_t id, const v1::JogRequest& request,
                                  const api::Snapshot& snapshot);
  /// Stops the robot if this viewer jogs it.
  void release(Viewer viewer);
  /// The robot has left the cell: ends the jog, and pending steps with the reason.
  void abandon() { finish("the robot has left the cell"); }
  /// Handles timeouts, ended motions and commands of other clients. Call it often.
  void tick(const api::Snapshot& snapshot, Clock::time_point now);

  /// A step that has ended, with its outcome.
  struct EndedStep {
    Viewer viewer = 0;
    std::uint32_t id = 0;
    Result<void> outcome;
  };
  /// Steps that have ended since the last call, in order.
  [[nodiscard]] std::vector<EndedStep> take_ended() { return std::exchange(ended_, {}); }

  [[nodiscard]] bool active() const { return jog_.has_value(); }
  /// Whether the current or last jog sent this command. The robot may refuse it near the end of its
  /// reach: a shorter motion follows, and finally an error to the viewer.
  [[nodiscard]] bool sent(api::Ticket ticket) const {
    return first_ <= ticket && ticket <= ticket_;
  }

 private:
  struct Jog {
    Viewer viewer = 0;
    v1::JogRequest wanted;
    std::string request;        // serialised, to detect changes; empty for steps
    Clock::time_point expires;  // unless renewed; not for steps
    std::uint64_t epoch = 0;
    bool begun = false;   // false: waits until the robot is at rest
    double stretch = 0;   // length of the last motion [m or rad]
    std::string blocked;  // reason why it cannot continue; empty = it can
    /// The robot executes a command of another client or was stopped by a fault: the jog has no
    /// motion to stop.
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
  /// Ends the jog; pending steps fail with `why`.
  void finish(const std::string& why);
  void stop(const std::string& why);
  /// Makes the robot ready again if it refused the abandoned motion.
  void forgive_refusal(const api::Snapshot& snapshot);
  [[nodiscard]] Result<void> submit(const api::RobotAction& action);

  int robot_;
  api::EndpointId endpoint_;
  api::CommandSink& sink_;
  std::chrono::milliseconds timeout_;
  std::shared_ptr<const api::CellDescription> cell_;
  std::optional<Jog> jog_;
  std::deque<Step> steps_;  // of jog_; the first is being executed
  std::vector<EndedStep> ended_;
  api::Ticket first_ = 1, ticket_ = 0;  // first of this jog, and last of all jogs
  bool stop_owed_ = false;              // the queue was full: send it later
  /// Epoch of an abandoned line, whose last motion the robot may have refused since.
  std::optional<std::uint64_t> given_up_;
};

}  // namespace aprsim::web
