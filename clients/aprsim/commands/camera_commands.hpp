#pragma once

#include <string>
#include <vector>

#include "clients/aprsim/commands/command_group.hpp"

/// Cameras of scenes.
namespace aprsim::client {

/// Fits a camera to a calibration's map and prints its entry for a scene.
struct CameraFitCommand {
  std::string map;                   ///< file of the map (.npz)
  std::vector<std::string> options;  ///< as given, of aprsim.camera_fit in Python
};

/// Becomes the Python program that fits; returns only when that cannot be started.
[[nodiscard]] Outcome<void> run_command(const CameraFitCommand& command, Console& console);

/// Their words and options.
void add_camera(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
