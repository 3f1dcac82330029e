#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "world/api/commands/conveyor_command.hpp"
#include "world/api/commands/robot_command.hpp"
#include "world/api/commands/scene_command.hpp"
#include "world/api/commands/simulation_command.hpp"
#include "world/api/faults/fault.hpp"
#include "world/api/values/light_curtain.hpp"

/// Everything that a listener may ask of the world. Plain values in SI units; a command says what
/// is wanted, never how a wire encoded it.
namespace aprsim::api {

/// Identifies the listener or client session that sent a command (kept in the journal).
using EndpointId = std::uint32_t;

/// Puts the intruder into the cell or moves it; nullopt takes it away. A reset does so too.
struct SetIntruder {
  std::optional<Intruder> intruder;
};

struct Command {
  EndpointId endpoint = 0;
  std::variant<RobotCommand, ConveyorCommand, SetIntruder, FaultCommand, SimulationCommand,
               SceneCommand>
      body;
};

}  // namespace aprsim::api
