#pragma once

#include <array>
#include <optional>
#include <vector>

#include "world/api/ports.hpp"
#include "world/api/snapshot.hpp"

namespace aprsim::crcl_server {

/// Submits one robot's actions and remembers the limits that it has set until snapshots show them.
/// Thread: the server's.
class CommandSubmitter {
 public:
  CommandSubmitter(int robot, api::EndpointId endpoint, api::CommandSink& sink)
      : robot_(robot), endpoint_(endpoint), sink_(sink) {}

  [[nodiscard]] Result<api::Ticket> submit(api::RobotAction action,
                                           std::vector<api::Guard> guards = {});

  /// A limit as clients have set it, also where the snapshot does not show that yet.
  [[nodiscard]] api::LimitSetting limit(api::MotionLimit which,
                                        const api::Snapshot& snapshot) const;

  /// The robot has been built anew, with its own limits.
  void forget() { latest_ = {}; }

 private:
  struct Latest {
    api::Ticket ticket = 0;
    api::LimitSetting set;
  };

  int robot_;
  api::EndpointId endpoint_;
  api::CommandSink& sink_;
  std::array<std::optional<Latest>, 4> latest_;  // by MotionLimit
};

}  // namespace aprsim::crcl_server
