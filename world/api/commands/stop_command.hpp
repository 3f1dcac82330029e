#pragma once

#include <variant>

#include "world/api/commands/command.hpp"

namespace aprsim::api {

/// Whether the command stops the belt and does nothing that could start it.
[[nodiscard]] inline bool is_stop(const ConveyorCommand& belt) {
  const bool stops = belt.run == false || belt.emergency_stop == true;
  return stops && belt.run != true && belt.emergency_stop != false && !belt.fault_reset;
}

/// Whether the command stops a stream's motion at once.
[[nodiscard]] inline bool is_stop(const TrajectoryAction& action) {
  const auto* release = std::get_if<ReleaseMotion>(&action);
  return std::holds_alternative<StopStream>(action) || (release && !release->when_done);
}

/// Whether the command is a stop: of a robot, of the belt, or of the simulation (a pause). Every
/// listener accepts stops without a limit and confirms them without waiting for a step.
[[nodiscard]] inline bool is_stop(const Command& command) {
  if (const auto* robot = std::get_if<RobotCommand>(&command.body)) {
    return std::holds_alternative<StopMotion>(robot->action);
  }
  if (const auto* belt = std::get_if<ConveyorCommand>(&command.body)) return is_stop(*belt);
  if (const auto* stream = std::get_if<TrajectoryCommand>(&command.body)) {
    return is_stop(stream->action);
  }
  const auto* simulation = std::get_if<SimulationCommand>(&command.body);
  return simulation != nullptr && std::holds_alternative<Pause>(*simulation);
}

}  // namespace aprsim::api
