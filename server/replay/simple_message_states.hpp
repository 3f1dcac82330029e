#pragma once

#include <optional>
#include <string>
#include <utility>

#include "protocols/simple_message/simple_message_server.hpp"
#include "server/replay/wire_reply.hpp"

namespace aprsim::server::journal {

/// Recomputes the states that a robot's Simple Message port has sent, as far as the cell alone
/// determines them: joints. Thread: one at a time.
class SimpleMessageStates {
 public:
  SimpleMessageStates(std::string robot, simple_message::ControllerKind controller)
      : robot_(std::move(robot)), controller_(controller) {}

  /// A message to the client; absent = it has no joints.
  [[nodiscard]] std::optional<WireReply> sent(const std::string& message, world::RunTime at) const;

 private:
  const std::string robot_;  ///< its name
  const simple_message::ControllerKind controller_;
};

}  // namespace aprsim::server::journal
