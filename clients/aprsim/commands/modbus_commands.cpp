#include "clients/aprsim/commands/modbus_commands.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/text/register_text.hpp"
#include "clients/wires/cell_connection.hpp"

namespace aprsim::client {
namespace {

void show_map(const v1::ModbusServer& map, const v1::CellDescription& cell, Console& console) {
  if (!console.json) return console.print(register_map_text(map, cell));
  for (const RegisterRow& row : register_rows(map, cell)) {
    console.show("", {{"server", map.name()},
                      {"area", row.area},
                      {"address", row.data->address()},
                      {"signal", row.data->signal()},
                      {"writable", row.data->writable()},
                      {"encoding", row.encoding},
                      {"word_order", row.word_order},
                      {"scale", row.data->scale()},
                      {"offset", row.data->offset()},
                      {"unit", row.unit},
                      {"meaning", row.meaning}});
  }
}

}  // namespace

Outcome<void> run_command(const ModbusMapCommand& command, Console& console) {
  const auto cell = CellConnection(console.endpoints).cell();
  if (!cell) return tl::unexpected(cell.error());
  std::string names;
  bool shown = false;
  for (const v1::ModbusServer& map : cell->modbus_servers()) {
    names += (names.empty() ? "" : ", ") + map.name();
    if (!command.server.empty() && map.name() != command.server) continue;
    if (shown && !console.json) console.print("\n");
    show_map(map, *cell, console);
    shown = true;
  }
  if (shown) return {};
  if (command.server.empty()) {
    return failed(FailureKind::kCheck,
                  fmt::format("scene {} describes no Modbus servers", cell->scene()));
  }
  return failed(FailureKind::kUsage,
                fmt::format("no Modbus server '{}' in scene {}; there is {}", command.server,
                            cell->scene(), names.empty() ? "none" : names));
}

void add_modbus(CLI::App& app, CommandLine& line) {
  CLI::App* modbus =
      app.add_subcommand("modbus", "Query the Modbus servers that the running scene describes");
  modbus->require_subcommand(1);
  auto [map, command] = add_command<ModbusMapCommand>(
      *modbus, line, "map", "Print the registers of a server, or of all of them");
  map->add_option("NAME", command->server, "Name of the server (default: all)");
  offer_json(*map, line, "Print one JSON object per register");
}

}  // namespace aprsim::client
