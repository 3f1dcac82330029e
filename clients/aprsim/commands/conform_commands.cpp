#include "clients/aprsim/commands/conform_commands.hpp"

#include <charconv>
#include <ostream>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/conform/check.hpp"
#include "clients/wires/cell_connection.hpp"

namespace aprsim::client {
namespace {

using conform::Target;

// "HOST:PORT" or "[ADDRESS]:PORT".
Outcome<Target> target_of(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  std::uint16_t port = 0;
  const char* end = address.data() + address.size();
  const bool complete =
      colon != std::string::npos && colon > 0 &&
      std::from_chars(address.data() + colon + 1, end, port) == std::from_chars_result{end, {}} &&
      port != 0;
  if (!complete) {
    return failed(FailureKind::kUsage, fmt::format("'{}' is not HOST:PORT", address));
  }
  std::string host = address.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  return Target{host, port};
}

modbus::Area area_in(v1::RegisterArea area) {
  switch (area) {
    case v1::REGISTER_AREA_COIL:
      return modbus::Area::kCoil;
    case v1::REGISTER_AREA_DISCRETE_INPUT:
      return modbus::Area::kDiscreteInput;
    case v1::REGISTER_AREA_INPUT_REGISTER:
      return modbus::Area::kInputRegister;
    default:
      return modbus::Area::kHoldingRegister;
  }
}

/// The addresses of a server of the running scene.
Outcome<conform::ModbusShape> shape_of(const std::string& server, Console& console) {
  const auto cell = CellConnection(console.endpoints).cell();
  if (!cell) return tl::unexpected(cell.error());
  conform::ModbusShape shape;
  for (const v1::ModbusServer& map : cell->modbus_servers()) {
    if (map.name() != server) continue;
    for (const v1::Register& each : map.registers()) {
      const int words = each.encoding() >= v1::REGISTER_ENCODING_UINT32 ? 2 : 1;
      for (int i = 0; i < words; ++i) {
        shape.add(area_in(each.area()),
                  static_cast<std::uint16_t>(each.address() + static_cast<std::uint32_t>(i)),
                  each.writable());
      }
    }
  }
  if (!shape.empty()) return shape;
  return failed(FailureKind::kUsage,
                fmt::format("no Modbus server '{}' in scene {}", server, cell->scene()));
}

/// Tests a server that the running scene describes.
Outcome<void> check_map(const ConformModbusCommand& command, Console& console) {
  const auto shape = shape_of(command.server, console);
  if (!shape) return tl::unexpected(shape.error());
  const auto port = console.endpoints.modbus_servers.find(command.server);
  if (command.address.empty() && port == console.endpoints.modbus_servers.end()) {
    return failed(FailureKind::kUsage,
                  fmt::format("the port of Modbus server '{}' is unknown: give HOST:PORT, or a "
                              "ports file",
                              command.server));
  }
  Outcome<Target> target = command.address.empty() ? Target{console.endpoints.host, port->second}
                                                   : target_of(command.address);
  if (!target) return tl::unexpected(target.error());
  target->allow_motion = command.allow_motion;
  target->read_one = conform::some_read(*shape, 1);
  target->read_many = conform::some_read(*shape, 125);
  return conform::check_server(conform::modbus_map_checks(*shape), *target, console);
}

}  // namespace

Outcome<void> run_command(const ConformCrclCommand& command, Console& console) {
  Outcome<Target> target;
  if (command.address.empty()) {
    const auto port = crcl_port(console.endpoints, command.robot);
    if (!port) return tl::unexpected(port.error());
    target = Target{console.endpoints.host, *port};
  } else {
    target = target_of(command.address);
  }
  if (!target) return tl::unexpected(target.error());
  target->allow_motion = command.allow_motion;
  target->sensor = command.sensor;
  return conform::check_server(conform::crcl_checks(), *target, console);
}

Outcome<void> run_command(const ConformModbusCommand& command, Console& console) {
  if (!command.server.empty()) return check_map(command, console);
  if (command.secure && command.address.empty()) {
    return failed(FailureKind::kUsage, "--secure needs the server's HOST:PORT");
  }
  Outcome<Target> target = command.address.empty()
                               ? Target{console.endpoints.host, console.endpoints.modbus}
                               : target_of(command.address);
  if (!target) return tl::unexpected(target.error());
  target->allow_motion = command.allow_motion;
  if (command.secure) target->encryption = console.endpoints.encryption.value_or(Encryption{});
  return conform::check_server(conform::modbus_checks(), *target, console);
}

Outcome<void> run_command(const ConformClausesCommand& /*command*/, Console& console) {
  console.print(conform::clauses_page("A robot's CRCL server", conform::crcl_checks()) + '\n' +
                conform::clauses_page("The conveyor's Modbus server", conform::modbus_checks()));
  return {};
}

void add_conform(CLI::App& app, CommandLine& line) {
  CLI::App* conform =
      app.add_subcommand("conform", "Test any CRCL or Modbus server for conformance");
  conform->require_subcommand(1);
  const auto add_common = [&line](CLI::App& sub, auto& command, const char* motion) {
    sub.add_option("ADDRESS", command.address,
                   "HOST:PORT of the server (default: the running cell)");
    sub.add_flag("--allow-motion", command.allow_motion, motion);
    offer_json(sub, line, "Print one JSON object per rule, and one with the score");
  };
  auto [crcl, crcl_command] =
      add_command<ConformCrclCommand>(*conform, line, "crcl", "Test a CRCL server");
  add_common(*crcl, *crcl_command,
             "Include checks that move the arm by some millimetres, and the gripper");
  auto* robot =
      crcl->add_option("--robot", crcl_command->robot, "Name of the robot, in place of an address")
          ->type_name("ROBOT");
  crcl->add_option("--sensor", crcl_command->sensor,
                   "Force sensor for the checks of guards (default: one with a known name)")
      ->type_name("ID")
      ->check(not_empty());
  // A forgotten word must not select another robot.
  crcl->callback([&line, robot, c = crcl_command] {
    if (robot->empty() == c->address.empty()) throw CLI::RequiredError("ADDRESS or --robot");
    line.command = *c;
  });
  auto [modbus, modbus_command] = add_command<ConformModbusCommand>(
      *conform, line, "modbus", "Test the conveyor's Modbus server, or one of the scene");
  auto* server = modbus
                     ->add_option("--server", modbus_command->server,
                                  "Name of a server that the running scene describes")
                     ->type_name("NAME")
                     ->check(not_empty());
  modbus
      ->add_flag("--secure", modbus_command->secure,
                 "Modbus Security at ADDRESS: TLS with the files of --ca, --certificate and --key")
      ->excludes(server);
  add_common(*modbus, *modbus_command, "Include checks that write registers, which runs the belt");
  add_command<ConformClausesCommand>(*conform, line, "clauses", "Print the rules as Markdown");
}

}  // namespace aprsim::client
