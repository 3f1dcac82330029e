#pragma once

#include <array>
#include <optional>
#include <span>

#include "world/api/ports.hpp"
#include "world/api/snapshot.hpp"

namespace aprsim::protocols {

/// Submits one robot's actions and keeps the limits that a pose sets for its own move apart from
/// those that clients have set for good. Thread: the server's.
class RobotCommander {
 public:
  RobotCommander(int robot, api::EndpointId endpoint, api::CommandSink& sink)
      : robot_(robot), endpoint_(endpoint), sink_(sink) {}

  [[nodiscard]] Result<api::Ticket> submit(const api::RobotAction& action);

  /// Submits the move under `overrides`. The world knows only limits that stay, so the former ones
  /// are set again before the next command that they could affect.
  [[nodiscard]] Result<api::Ticket> submit_overridden(
      const api::MoveTo& move, std::span<const api::SetMotionLimit> overrides,
      const api::Snapshot& snapshot);

  /// A limit as clients have set it for good.
  [[nodiscard]] api::LimitSetting limit(api::MotionLimit which,
                                        const api::Snapshot& snapshot) const;

  /// The robot has been built anew, with its own limits.
  void forget() { kept_ = {}; }

 private:
  struct Kept {
    api::Ticket ticket = 0;
    api::LimitSetting set;  // for good
    bool overridden = false;
  };
  [[nodiscard]] Result<api::Ticket> send(const api::RobotAction& action);
  [[nodiscard]] Result<void> restore(const api::RobotAction& next);

  int robot_;
  api::EndpointId endpoint_;
  api::CommandSink& sink_;
  std::array<std::optional<Kept>, 4> kept_;  // by MotionLimit
};

}  // namespace aprsim::protocols
