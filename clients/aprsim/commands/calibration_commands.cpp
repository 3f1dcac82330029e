#include "clients/aprsim/commands/calibration_commands.hpp"

#include <CLI/CLI.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/cli/python_program.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"

namespace aprsim::client {
namespace {

/// Declares an option that is passed on as it is given, as often as it is given.
template <typename Command>
CLI::Option* pass_on(CLI::App& app, const std::shared_ptr<Command>& command,
                     const std::string& name, const char* help, const char* type) {
  return app
      .add_option_function<std::vector<std::string>>(
          name,
          [command, name](const std::vector<std::string>& values) {
            for (const std::string& value : values) command->options.push_back(name + "=" + value);
          },
          help)
      ->type_name(type)
      ->allow_extra_args(false);
}

Outcome<void> become_calibration(const char* program, const std::vector<std::string>& captures,
                                 const std::vector<std::string>& options, bool json) {
  std::vector<std::string> words = {"aprsim.calibration", program};
  words.insert(words.end(), options.begin(), options.end());
  if (json) words.emplace_back("--json");
  words.emplace_back("--");
  words.insert(words.end(), captures.begin(), captures.end());
  return become_python(words);
}

template <typename Command>
void add_shared(CLI::App& app, const std::shared_ptr<Command>& command) {
  pass_on(app, command, "--scene", "Scene of the cell: a name or a file", "SCENE")->required();
  pass_on(app, command, "--robot",
          "Robot of force logs and camera lines (default: the scene's first)", "NAME");
}

}  // namespace

Outcome<void> run_command(const CalibrateCommand& command, Console& console) {
  return become_calibration("calibrate", command.captures, command.options, console.json);
}

Outcome<void> run_command(const CompareCommand& command, Console& console) {
  return become_calibration("compare", {command.capture}, command.options, console.json);
}

void add_calibration(CLI::App& app, CommandLine& line) {
  auto [calibrate, fit] = add_command<CalibrateCommand>(
      app, line, "calibrate", "Estimate a scene's parameters from recordings of the real cell");
  calibrate
      ->add_option("CAPTURE", fit->captures,
                   "Journals (of trace import or of a daemon), force logs (CSV), camera lines")
      ->required();
  add_shared(*calibrate, fit);
  pass_on(*calibrate, fit, "--out", "Write a scene with the estimates, whose base is the scene",
          "FILE");
  offer_json(*calibrate, line, "Print the estimates as one JSON object");
  auto [compare, against] = add_command<CompareCommand>(
      app, line, "compare", "Run the commands of a recording in a scene and compare the motion");
  compare
      ->add_option("CAPTURE", against->capture,
                   "Journal (of trace import or of a daemon), force log (CSV), or camera lines")
      ->required();
  add_shared(*compare, against);
  pass_on(*compare, against, "--limit",
          "Exit with 1 if a root mean square is larger: position_mm, angle_deg, time_s, "
          "speed_m_s, force_n",
          "NAME=NUMBER");
  offer_json(*compare, line, "Print the comparison as one JSON object");
}

}  // namespace aprsim::client
