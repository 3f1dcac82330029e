#include "clients/aprsim/command_line.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <sstream>

#include <CLI/CLI.hpp>

namespace aprsim::client {
namespace {

constexpr int kUsageError = 2;

/// The whole text as a finite number.
std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

void set_belt_speed(ConveyorSetCommand& command, const std::string& text) {
  const bool percent = text.ends_with('%');
  const auto value = number(std::string_view(text).substr(0, text.size() - (percent ? 1 : 0)));
  if (!value || *value < 0 || (percent && *value > 100)) {
    throw CLI::ValidationError(
        "--speed", "'" + text + "' is neither a speed in m/s from 0 up nor a percentage 0%..100%");
  }
  (percent ? command.speed_percent : command.speed_m_s) = *value;
}

void set_factor(SpeedCommand& command, const std::string& text) {
  if (text == "max") return;
  command.factor = number(text);
  if (!command.factor || *command.factor < 1e-3 || *command.factor > 1e6) {
    throw CLI::ValidationError("X", "'" + text + "' is neither within 0.001 and 1e6 nor 'max'");
  }
}

void set_crcl_port(EndpointChoice& choice, const std::string& text) {
  const auto equals = text.find('=');
  const auto port = equals == std::string::npos ? std::nullopt
                                                : number(std::string_view(text).substr(equals + 1));
  if (equals == 0 || !port || *port != std::floor(*port) || *port < 1 || *port > 65535) {
    throw CLI::ValidationError("--crcl-port", "'" + text + "' is not ROBOT=PORT");
  }
  choice.crcl[text.substr(0, equals)] = static_cast<std::uint16_t>(*port);
}

/// Parser of one subcommand: fills `command` and marks it as the chosen one.
template <typename Command>
std::pair<CLI::App*, std::shared_ptr<Command>> add(CLI::App& app, CommandLine& line,
                                                   const char* name, const char* help) {
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand(name, help);
  sub->callback([&line, command] { line.command = *command; });
  return {sub, command};
}

void add_endpoints(CLI::App& app, EndpointChoice& choice) {
  app.add_option("--ports-file", choice.ports_file,
                 "File of ports written by aprsimd (default: $APRSIM_PORTS_FILE)");
  app.add_option("--host", choice.host, "Host of the daemon (default 127.0.0.1)");
  app.add_option("--token-file", choice.token_file,
                 "File whose first line is the daemon's access token (default: $APRSIM_TOKEN)");
  app.add_option("--grpc-port", choice.grpc, "gRPC port (default 50051)");
  app.add_option("--modbus-port", choice.modbus, "Modbus port (default 1502)");
  app.add_option_function<std::vector<std::string>>(
      "--crcl-port",
      [&choice](const std::vector<std::string>& all) {
        for (const auto& one : all) set_crcl_port(choice, one);
      },
      "CRCL port as ROBOT=PORT (default fanuc=64444, motoman=64445)");
}

void add_reading(CLI::App& app, CommandLine& line) {
  auto [status, status_command] =
      add<StatusCommand>(app, line, "status", "Show the cell as it is now");
  status->add_flag("--json", status_command->json, "The whole snapshot as JSON");
  status->add_flag("--bodies", status_command->bodies, "Also a line for each gear and tray");
  auto [watch, watch_command] =
      add<WatchCommand>(app, line, "watch", "Show one line a sample until interrupted");
  watch->add_option("--rate", watch_command->rate_hz, "Samples a second (default 20)");
  watch->add_option("--count", watch_command->count, "End after so many samples");
  watch->add_flag("--json", watch_command->json, "One JSON object a line");
}

void add_crcl_files(CLI::App& crcl, CommandLine& line) {
  auto [send, send_command] = add<CrclSendCommand>(
      crcl, line, "send",
      "Send the CRCLCommandInstance documents of a file, each when the last is done");
  send->add_option("FILE", send_command->file)->required();
  send->add_option("--robot", send_command->robot, "Name of the robot")->required();
  send->add_option("--timeout", send_command->timeout_s, "Seconds for each command (default 120)");
  auto [run, run_command] =
      add<CrclRunCommand>(crcl, line, "run", "Run a CRCLProgram, one command at a time");
  run->add_option("PROGRAM", run_command->file)->required();
  run->add_option("--robot", run_command->robot, "Name of the robot")->required();
  run->add_option("--timeout", run_command->timeout_s, "Seconds for each command (default 120)");
}

void add_crcl_status(CLI::App& crcl, CommandLine& line) {
  auto [status, command] =
      add<CrclStatusCommand>(crcl, line, "status", "Show a robot's status in one line");
  status->add_option("--robot", command->robot, "Name of the robot")->required();
  status->add_flag("--watch", command->watch, "Again and again until interrupted");
  status->add_option("--rate", command->rate_hz, "Samples a second (default 10)");
  status->add_option("--count", command->count, "End after so many samples");
}

void add_crcl_jog(CLI::App& crcl, CommandLine& line) {
  auto [jog, command] = add<CrclJogCommand>(
      crcl, line, "jog", "Move one joint (degrees), or the tool straight along an axis (mm)");
  jog->add_option("--robot", command->robot, "Name of the robot")->required();
  auto* joint = jog->add_option("--joint", command->joint, "Number of the joint, from 1");
  jog->add_option("--axis", command->axis, "x, y or z of the robot's frame (default x)")
      ->check(CLI::IsMember({'x', 'y', 'z'}))
      ->excludes(joint);
  jog->add_option("--by", command->by, "How far, from where it is")->required();
  jog->add_option("--speed", command->speed, "Degrees or mm a second")->check(CLI::PositiveNumber);
  jog->add_flag("--init", command->init, "InitCanon first");
}

void add_crcl(CLI::App& app, CommandLine& line) {
  CLI::App* crcl = app.add_subcommand("crcl", "Command a robot");
  crcl->require_subcommand(1);
  add_crcl_files(*crcl, line);
  add_crcl_status(*crcl, line);
  add_crcl_jog(*crcl, line);
  auto [validate, command] = add<CrclValidateCommand>(
      *crcl, line, "validate", "Check the CRCL documents of a file against the schema");
  validate->add_option("FILE", command->file)->required();
}

template <typename Command>
void add_scaling(CLI::App& app, Command& command) {
  app.add_option("--full-scale", command.full_scale_m_s,
                 "Belt speed at 32768 counts in m/s (default 0.32768)")
      ->check(CLI::PositiveNumber);
  app.add_flag("!--zero-is-forward", command.one_is_forward,
               "0 in the direction register means forward (default: 1 does)");
}

void add_conveyor(CLI::App& app, CommandLine& line) {
  CLI::App* conveyor = app.add_subcommand("conveyor", "Command the belt over Modbus");
  conveyor->require_subcommand(1);
  auto [set, command] =
      add<ConveyorSetCommand>(*conveyor, line, "set", "Run the belt, or stop it with --stop");
  auto speed = set->add_option_function<std::string>(
      "--speed", [c = command](const std::string& text) { set_belt_speed(*c, text); },
      "m/s, or a percentage of full scale such as 50%");
  set->add_option_function<std::string>(
         "--direction", [c = command](const std::string& text) { c->forward = text == "forward"; },
         "forward or reverse")
      ->check(CLI::IsMember({"forward", "reverse"}));
  set->add_flag("--stop", command->stop, "Stop the belt")->excludes(speed);
  add_scaling(*set, *command);
  auto [map, map_command] =
      add<ConveyorMapCommand>(*conveyor, line, "map", "Print the Modbus register map");
  add_scaling(*map, *map_command);
}

void add_simulation(CLI::App& app, CommandLine& line) {
  add<PauseCommand>(app, line, "pause", "Stop taking steps");
  add<ResumeCommand>(app, line, "resume", "Take steps again");
  auto [step, step_command] =
      add<StepCommand>(app, line, "step", "Take so many steps while paused");
  step->add_option("N", step_command->steps, "Number of steps (default 1)")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{10'000'000}));
  auto [speed, speed_command] =
      add<SpeedCommand>(app, line, "speed", "Set the ratio of simulated to wall time");
  speed
      ->add_option_function<std::string>(
          "X", [c = speed_command](const std::string& text) { set_factor(*c, text); },
          "Factor above 0, or max")
      ->required();
  auto [reset, reset_command] = add<ResetCommand>(app, line, "reset", "Build the cell anew");
  reset->add_option("--seed", reset_command->seed, "Seed of everything random");
  auto [save, save_command] =
      add<SaveCommand>(app, line, "save", "Keep the cell's state under a name, in the daemon");
  save->add_option("NAME", save_command->name, "What to call it")->required();
  auto [load, load_command] = add<LoadCommand>(app, line, "load", "Go on from a saved state");
  load->add_option("NAME", load_command->name, "As it was saved")->required();
}

void add_intruder(CLI::App& app, CommandLine& line) {
  CLI::App* intruder = app.add_subcommand(
      "intruder", "Let the cell's sensors see a person or object that nothing touches");
  intruder->require_subcommand(1);
  auto [put, command] =
      add<IntruderCommand>(*intruder, line, "put", "Put it on the floor, or move it");
  put->add_option_function<std::array<double, 2>>(
         "XY", [c = command](const std::array<double, 2>& xy) { c->xy_m = xy; },
         "Where its middle stands, in the world [m]")
      ->required();
  put->add_option("--size", command->size_m, "Extent along x, y and z [m] (default 0.5 0.3 1.75)");
  add<IntruderCommand>(*intruder, line, "remove", "Take it away");
}

void add_demo(CLI::App& app, CommandLine& line) {
  auto [demo, command] = add<DemoCommand>(
      app, line, "demo", "Pick and place with the robots and run the belt, over the wires alone");
  demo->add_option("--robot", command->robots, "Only this robot's part; may be given twice");
  demo->add_flag("--belt", command->belt, "Only the belt's part (besides that of robots named)");
}

}  // namespace

tl::expected<CommandLine, NoCommand> parse_command_line(std::vector<std::string> arguments) {
  CommandLine line;
  CLI::App app("Client of the simulated kitting cell aprsimd", "aprsim");
  app.require_subcommand(1);
  app.fallthrough();
  app.set_version_flag("--version", APRSIM_VERSION);
  add_endpoints(app, line.endpoints);
  add_reading(app, line);
  add_crcl(app, line);
  add_conveyor(app, line);
  add_simulation(app, line);
  add_intruder(app, line);
  add_demo(app, line);
  try {
    std::ranges::reverse(arguments);
    app.parse(std::move(arguments));
  } catch (const CLI::ParseError& error) {
    std::ostringstream out, err;
    const int code = app.exit(error, out, err);
    if (code == 0) return tl::unexpected(NoCommand{0, out.str()});
    return tl::unexpected(NoCommand{kUsageError, err.str()});
  }
  return line;
}

}  // namespace aprsim::client
