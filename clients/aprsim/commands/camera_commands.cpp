#include "clients/aprsim/commands/camera_commands.hpp"

#include <CLI/CLI.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/cli/python_program.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"

namespace aprsim::client {
namespace {

/// Declares an option that is passed on as it is given.
CLI::Option* pass_on(CLI::App& app, const std::shared_ptr<CameraFitCommand>& command,
                     const std::string& name, const char* help, const char* type, int count = 1) {
  return app
      .add_option_function<std::vector<std::string>>(
          name,
          [command, name](const std::vector<std::string>& values) {
            // A value may begin with a minus.
            if (values.size() == 1) return command->options.push_back(name + "=" + values.front());
            command->options.push_back(name);
            command->options.insert(command->options.end(), values.begin(), values.end());
          },
          help)
      ->type_name(type)
      ->expected(count);
}

}  // namespace

Outcome<void> run_command(const CameraFitCommand& command, Console& /*console*/) {
  std::vector<std::string> words = {"aprsim.camera_fit"};
  words.insert(words.end(), command.options.begin(), command.options.end());
  words.push_back("--");
  words.push_back(command.map);
  return become_python(words);
}

void add_camera(CLI::App& app, CommandLine& line) {
  CLI::App* camera = app.add_subcommand("camera", "Cameras of scenes");
  camera->require_subcommand(1);
  auto [fit, command] = add_command<CameraFitCommand>(
      *camera, line, "fit", "Fit a camera to a calibration's map, and print its entry for a scene");
  fit->add_option("MAP", command->map, "Map from points to pixels (.npz)")->required();
  pass_on(*fit, command, "--size", "Width and height of the frame [px]", "WIDTH HEIGHT", 2)
      ->required();
  pass_on(*fit, command, "--origin-m", "Point of the map's first element in the world", "X Y Z", 3)
      ->required();
  pass_on(*fit, command, "--columns", "Axis along which columns run (default +x)", "AXIS");
  pass_on(*fit, command, "--rows", "Axis along which rows run (default +y)", "AXIS");
  pass_on(*fit, command, "--pitch-mm", "Distance of neighbours (default 25.4 / 30)", "MM");
  pass_on(*fit, command, "--every", "Take each N-th element of rows and columns (default 30)", "N");
  pass_on(*fit, command, "--terms", "Terms of distortion (default 1)", "N");
  pass_on(*fit, command, "--focal-px", "Known focal length, which is kept", "PX");
  pass_on(*fit, command, "--name", "Name of the camera in the scene", "NAME");
  fit->add_flag_callback(
      "--centre", [command = command] { command->options.push_back("--centre"); },
      "Fit the principal point, too; else it is the frame's middle");
}

}  // namespace aprsim::client
