#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "protocols/simple_message/codec/io_address.hpp"
#include "protocols/simple_message/codec/message.hpp"
#include "protocols/simple_message/gripper_valves.hpp"

namespace aprsim::simple_message {

/// Signals and registers of the Motoman. Outputs 10010 to 10012 are the gripper's valves and air;
/// output 11120 shows that trajectories are taken; all others only keep what is written. Thread:
/// the listener's.
class MotomanIo {
 public:
  explicit MotomanIo(RobotLink& link) : valves_(link) {}

  /// The reply to a read or write of I/O; nullopt for other messages. `ready`: trajectories are
  /// taken.
  [[nodiscard]] std::optional<Message> answer(const Message& request, bool ready);

 private:
  [[nodiscard]] Message read(MessageType type, MessageType reply, IoSize size, const Body& body,
                             bool ready);
  [[nodiscard]] Message write(MessageType reply, IoSize size, const Body& body);
  [[nodiscard]] bool bit(std::int32_t address, bool ready);
  [[nodiscard]] Result<void> set_bit(std::int32_t address, bool on);

  GripperValves valves_;
  std::map<std::int32_t, std::int32_t> values_;  // written bits and registers; others are 0
};

}  // namespace aprsim::simple_message
