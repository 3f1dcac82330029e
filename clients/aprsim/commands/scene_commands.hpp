#pragma once

#include <array>
#include <string>

#include "clients/aprsim/commands/command_group.hpp"

/// Commands for the running scene.
namespace aprsim::client {

struct SceneShowCommand {};
struct SceneListCommand {};
struct SceneTypesCommand {};
struct SceneSpawnCommand {
  std::string type, name;
  std::array<double, 3> at_m{};  ///< in the world
  double yaw_deg = 0;
};
struct SceneMoveCommand {
  std::string name;
  std::array<double, 3> at_m{};  ///< in the world
  double yaw_deg = 0;
};
struct SceneRemoveCommand {
  std::string name;
};
struct SceneSetCommand {
  std::string path, value;
};

[[nodiscard]] Outcome<void> run_command(const SceneShowCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const SceneListCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const SceneTypesCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const SceneSpawnCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const SceneMoveCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const SceneRemoveCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const SceneSetCommand& command, Console& console);

/// Their words and options.
void add_scene(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
