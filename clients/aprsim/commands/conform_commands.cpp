#include "clients/aprsim/commands/conform_commands.hpp"

#include <charconv>
#include <ostream>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/conform/check.hpp"

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
  Outcome<Target> target = command.address.empty()
                               ? Target{console.endpoints.host, console.endpoints.modbus}
                               : target_of(command.address);
  if (!target) return tl::unexpected(target.error());
  target->allow_motion = command.allow_motion;
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
      *conform, line, "modbus", "Test the conveyor's Modbus server");
  add_common(*modbus, *modbus_command, "Include checks that write registers, which runs the belt");
  add_command<ConformClausesCommand>(*conform, line, "clauses", "Print the rules as Markdown");
}

}  // namespace aprsim::client
