#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <variant>

#include "world/api/commands/conveyor_command.hpp"
#include "world/api/commands/robot_command.hpp"
#include "world/api/commands/scene_command.hpp"
#include "world/api/commands/signal_command.hpp"
#include "world/api/commands/simulation_command.hpp"
#include "world/api/commands/trajectory_command.hpp"
#include "world/api/faults/fault.hpp"
#include "world/api/values/light_curtain.hpp"

/// The commands of listeners to the world. Plain values in SI units, independent of the encoding of
/// a wire.
namespace aprsim::api {

/// Identifies the listener or client session that sent a command (kept in the journal).
using EndpointId = std::uint32_t;

/// Adds the intruder to the cell or moves it; nullopt removes it. A reset removes it, too.
struct SetIntruder {
  std::optional<Intruder> intruder;
};

struct CellDescription;

struct Command {
  EndpointId endpoint = 0;
  std::variant<RobotCommand, ConveyorCommand, SetIntruder, FaultCommand, SimulationCommand,
               SceneCommand, TrajectoryCommand, SetSignals>
      body;
  /// The description that a robot's index was taken from. Where another scene has another robot at
  /// that index, the command fails. Null = the one at submission.
  std::shared_ptr<const CellDescription> cell{};
};

}  // namespace aprsim::api
