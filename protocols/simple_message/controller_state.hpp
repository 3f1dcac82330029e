#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "protocols/simple_message/codec/message.hpp"
#include "protocols/simple_message/simple_message_server.hpp"
#include "world/api/snapshot/snapshot.hpp"

/// A robot of a snapshot as its controller sees it. Pure; thread: any.
namespace aprsim::simple_message {

/// Joints in the model's order [rad].
using JointVector = std::vector<double>;

/// The controller's joints from the model's: the Fanuc counts its third joint against the
/// horizontal. The Motoman's wire has S L E U R B T, as the model.
[[nodiscard]] Joints to_wire(ControllerKind kind, std::span<const double> joints);
/// Measured joints as the controller reports them: the Motoman's encoders count whole pulses.
[[nodiscard]] Joints measured_to_wire(ControllerKind kind, std::span<const double> joints);
/// The model's joints from the first `count` of the wire.
[[nodiscard]] JointVector from_wire(ControllerKind kind, const Joints& wire, std::size_t count);

struct ControllerState {
  Joints position{}, velocity{};  ///< measured [rad, rad/s]
  JointVector reference_rad;      ///< commanded, in the model's order
  JointVector measured_rad;       ///< in the model's order
  bool drives_on = false;
  bool e_stopped = false;
  bool in_error = false;        ///< an alarm is held
  bool moving = false;          ///< a command or a stream moves the robot
  bool others_command = false;  ///< somebody but the given stream moves the robot or has it
  bool has_stream = false;      ///< the given stream has the robot
  std::int32_t error_code = 0;  ///< 0 = none
};

/// `stream` is the number of the controller's own stream, 0 = none.
[[nodiscard]] ControllerState state_of(const api::Snapshot& snapshot, int robot,
                                       ControllerKind kind, api::Ticket stream);

/// The Motoman's encoders: whole pulses of each axis, truncated as MotoROS does, in the order S L E
/// U R B T.
[[nodiscard]] std::vector<std::int64_t> pulses_of(std::span<const double> joints_rad);
/// The angles of these pulses: a commanded position as the Motoman keeps it.
[[nodiscard]] JointVector on_whole_pulses(JointVector joints_rad);
/// Whether each axis of `a` is within `limit` pulses of `b`.
[[nodiscard]] bool within_pulses(std::span<const double> a_rad, std::span<const double> b_rad,
                                 std::int64_t limit);

}  // namespace aprsim::simple_message
