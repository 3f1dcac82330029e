#pragma once

#include <cstdint>
#include <optional>

#include "protocols/simple_message/robot_link.hpp"

namespace aprsim::simple_message {

/// The pneumatic gripper behind a controller's outputs: a valve that opens, one that closes, and
/// the air. Fingers move only with air and with exactly one valve on; otherwise they stay. Thread:
/// the listener's.
class GripperValves {
 public:
  explicit GripperValves(RobotLink& link) : link_(link) {}

  enum class Output : std::uint8_t { kOpen, kClose, kAir };
  /// Switches an output. Error: the cell takes no commands now; the output stays as it was.
  [[nodiscard]] Result<void> set(Output output, bool on);
  /// As the controller reports it. Valves that another commander of the gripper has switched show.
  [[nodiscard]] bool get(Output output);
  /// Opens or closes, air and valves included.
  [[nodiscard]] Result<void> actuate(bool open);
  /// As last commanded, by whomever.
  [[nodiscard]] bool is_open();

 private:
  struct Valves {
    bool open = true, close = false, air = false;
  };

  /// Adopts what others have commanded.
  void follow(const api::Snapshot& snapshot);
  [[nodiscard]] Result<void> apply(const Valves& valves);
  void make_ready();

  RobotLink& link_;
  Valves valves_;
  bool begun_ = false;       // the valves show the first state of the gripper
  api::Ticket pending_ = 0;  // our latest command
};

}  // namespace aprsim::simple_message
