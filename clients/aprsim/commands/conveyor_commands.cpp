#include "clients/aprsim/commands/conveyor_commands.hpp"

#include <cmath>
#include <ostream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/text/conveyor_text.hpp"
#include "clients/wires/conveyor_connection.hpp"
#include "modbus/register_map.hpp"

namespace aprsim::client {
namespace {

/// The count of the requested speed for the speed register; absent without a speed.
Outcome<std::optional<std::uint16_t>> speed_count(const ConveyorSetCommand& command) {
  if (!command.speed_percent && !command.speed_m_s) return std::nullopt;
  const double fraction = command.speed_percent ? *command.speed_percent / 100
                                                : *command.speed_m_s / command.full_scale_m_s;
  if (fraction > 1) {
    return failed(FailureKind::kUsage, fmt::format("{} m/s is more than the full scale of {} m/s",
                                                   *command.speed_m_s, command.full_scale_m_s));
  }
  return static_cast<std::uint16_t>(std::lround(fraction * modbus::kSpeedFullScaleCounts));
}

std::string_view area_name(modbus::Area area) {
  switch (area) {
    case modbus::Area::kCoil:
      return "coil";
    case modbus::Area::kDiscreteInput:
      return "discrete_input";
    case modbus::Area::kInputRegister:
      return "input_register";
    case modbus::Area::kHoldingRegister:
      return "holding_register";
  }
  return "";
}

std::string_view encoding_name(modbus::Encoding encoding) {
  switch (encoding) {
    case modbus::Encoding::kBit:
      return "bit";
    case modbus::Encoding::kUint16:
      return "uint16";
    case modbus::Encoding::kInt16:
      return "int16";
    case modbus::Encoding::kUint32:
      return "uint32";
    case modbus::Encoding::kInt32:
      return "int32";
  }
  return "";
}

void set_belt_speed(ConveyorSetCommand& command, const std::string& text) {
  const bool percent = text.ends_with('%');
  const auto value = number_of(std::string_view(text).substr(0, text.size() - (percent ? 1 : 0)));
  if (!value || *value < 0 || (percent && *value > 100)) {
    throw CLI::ValidationError(
        "--speed", "'" + text + "' is not a speed of at least 0 m/s or a percentage 0%..100%");
  }
  (percent ? command.speed_percent : command.speed_m_s) = *value;
}

template <typename Command>
Outcome<ConveyorConnection> connect(const Command& command, const Console& console) {
  return command.secure ? ConveyorConnection::connect_securely(console.endpoints)
                        : ConveyorConnection::connect(console.endpoints);
}

template <typename Command>
void add_secure(CLI::App& app, Command& command) {
  app.add_flag("--secure", command.secure,
               "Modbus Security: TLS with the files of --ca, --certificate and --key");
}

template <typename Command>
void add_scaling(CLI::App& app, Command& command) {
  app.add_option("--full-scale", command.full_scale_m_s,
                 "Belt speed at 32768 counts [m/s] (default 0.32768)")
      ->type_name("M/S")
      ->check(within(1e-3, 100));
  app.add_flag("!--zero-is-forward", command.one_is_forward,
               "Forward is 0 in the direction register (default: 1)");
}

}  // namespace

Outcome<void> run_command(const ConveyorSetCommand& command, Console& console) {
  // A forgotten option must not start the belt.
  if (!command.stop && !command.forward && !command.speed_percent && !command.speed_m_s) {
    return failed(FailureKind::kUsage, "no setting given; expected --speed, --direction or --stop");
  }
  const auto speed = speed_count(command);
  if (!speed) return tl::unexpected(speed.error());
  auto conveyor = connect(command, console);
  if (!conveyor) return tl::unexpected(conveyor.error());
  const auto write = [&](const char* name, std::uint16_t address,
                         std::uint16_t value) -> Outcome<void> {
    auto done = conveyor->write(address, value);
    if (done) {
      console.show(fmt::format("{} (0x{:04X}) = {}\n", name, address, value),
                   {{"register", name}, {"address", address}, {"value", value}});
    }
    return done;
  };
  // Starting is written last and stopping first, so the belt never runs with an old direction or
  // speed.
  if (command.stop) {
    if (auto done = write("run", modbus::kRunRegister, 0); !done) return done;
  }
  if (command.forward) {
    const bool one = *command.forward == command.one_is_forward;
    if (auto done = write("direction", modbus::kDirectionRegister, one ? 1 : 0); !done) return done;
  }
  if (*speed) {
    if (auto done = write("speed", modbus::kSpeedRegister, **speed); !done) return done;
  }
  return command.stop ? Outcome<void>() : write("run", modbus::kRunRegister, 1);
}

Outcome<void> run_command(const ConveyorStatusCommand& command, Console& console) {
  auto conveyor = connect(command, console);
  if (!conveyor) return tl::unexpected(conveyor.error());
  const auto image = conveyor->read();
  if (!image) return tl::unexpected(image.error());
  const auto state = conveyor_state(
      *image, {.full_scale_m_s = command.full_scale_m_s, .one_is_forward = command.one_is_forward});
  console.show(conveyor_text(state, console.screen.out), conveyor_json(state));
  const std::string problem = conveyor_problem(state);
  return problem.empty() ? Outcome<void>() : failed(FailureKind::kCheck, problem);
}

Outcome<void> run_command(const ConveyorMapCommand& command, Console& console) {
  const modbus::ConveyorScaling scaling{.full_scale_m_s = command.full_scale_m_s,
                                        .one_is_forward = command.one_is_forward};
  for (const auto& info :
       console.json ? modbus::register_map() : std::span<const modbus::RegisterInfo>()) {
    const double unit_per_count = modbus::resolution(info.scaling, scaling);
    console.show("", {{"area", area_name(info.area)},
                      {"address", info.address},
                      {"name", info.name},
                      {"values", info.count},
                      {"writable", info.access == modbus::Access::kReadWrite},
                      {"encoding", encoding_name(info.encoding)},
                      {"unit", info.unit},
                      {"unit_per_count", unit_per_count > 0 ? unit_per_count : 1},
                      {"min", info.min},
                      {"max", info.max},
                      {"meaning", info.meaning}});
  }
  if (!console.json) console.print(modbus::register_map_text(scaling));
  return {};
}

void add_conveyor(CLI::App& app, CommandLine& line) {
  CLI::App* conveyor = app.add_subcommand("conveyor", "Command and query the belt over Modbus");
  conveyor->require_subcommand(1);
  auto [status, status_command] = add_command<ConveyorStatusCommand>(
      *conveyor, line, "status", "Show the drive and sensors of the belt");
  add_secure(*status, *status_command);
  add_scaling(*status, *status_command);
  offer_json(*status, line);
  auto [set, command] = add_command<ConveyorSetCommand>(*conveyor, line, "set",
                                                        "Run the belt, or stop it with --stop");
  auto speed =
      set->add_option_function<std::string>(
             "--speed", [c = command](const std::string& text) { set_belt_speed(*c, text); },
             "Speed in m/s, or a percentage of full scale such as 50%")
          ->type_name("SPEED");
  choose(
      set->add_option_function<std::string>(
          "--direction", [c = command](const std::string& text) { c->forward = text == "forward"; },
          "Direction of travel"),
      {"forward", "reverse"});
  set->add_flag("--stop", command->stop, "Stop the belt")->excludes(speed);
  add_secure(*set, *command);
  add_scaling(*set, *command);
  offer_json(*set, line, "Print one JSON object for each register written");
  auto [map, map_command] = add_command<ConveyorMapCommand>(*conveyor, line, "map",
                                                            "Print all registers; needs no daemon");
  add_scaling(*map, *map_command);
  offer_json(*map, line, "Print one JSON object per register");
}

}  // namespace aprsim::client
