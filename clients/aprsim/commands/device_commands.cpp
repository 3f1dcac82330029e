#include "clients/aprsim/commands/device_commands.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/commands/receipt_text.hpp"
#include "clients/wires/cell_connection.hpp"

namespace aprsim::client {

Outcome<void> run_command(const DeviceSetCommand& command, Console& console) {
  const auto receipt =
      CellConnection(console.endpoints).set_signal(command.device, command.signal, command.value);
  if (!receipt) return tl::unexpected(receipt.error());
  const std::string what =
      fmt::format("{}.{} = {:g}", command.device, command.signal, command.value);
  return show_receipt(
      "device set", what, *receipt, console,
      {{"device", command.device}, {"signal", command.signal}, {"value", command.value}});
}

void add_device(CLI::App& app, CommandLine& line) {
  CLI::App* device = app.add_subcommand("device", "Command the devices of extensions");
  device->require_subcommand(1);
  auto [set, command] =
      add_command<DeviceSetCommand>(*device, line, "set", "Set an input of a device to a value");
  set->add_option("NAME", command->device, "Name of the device in the scene")->required();
  set->add_option("SIGNAL", command->signal, "Name of the input")->required();
  set->add_option("VALUE", command->value, "Value in the unit of the input")
      ->check(finite())
      ->required();
  offer_json(*set, line);
}

}  // namespace aprsim::client
