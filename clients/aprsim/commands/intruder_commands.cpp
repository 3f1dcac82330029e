#include "clients/aprsim/commands/intruder_commands.hpp"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/commands/receipt_text.hpp"
#include "clients/wires/cell_connection.hpp"

namespace aprsim::client {

Outcome<void> run_command(const IntruderCommand& command, Console& console) {
  std::optional<v1::Intruder> intruder;
  if (command.xy_m) {
    auto& centre = *intruder.emplace().mutable_intruder_in_world()->mutable_position_m();
    centre.set_x((*command.xy_m)[0]);
    centre.set_y((*command.xy_m)[1]);
    centre.set_z(command.size_m[2] / 2);
    intruder->mutable_size_m()->set_x(command.size_m[0]);
    intruder->mutable_size_m()->set_y(command.size_m[1]);
    intruder->mutable_size_m()->set_z(command.size_m[2]);
  }
  const auto response = CellConnection(console.endpoints).set_intruder(intruder);
  if (!response) return tl::unexpected(response.error());
  std::string what = intruder ? "intruder placed" : "intruder removed";
  auto fields = nlohmann::ordered_json::object();
  if (response->has_light_curtain()) {
    const char* state = response->light_curtain().broken() ? "broken" : "clear";
    what = fmt::format("light curtain {}, {}", state, what);
    fields["light_curtain"] = state;
  }
  return show_receipt(intruder ? "intruder place" : "intruder remove", what, response->receipt(),
                      console, fields);
}

void add_intruder(CLI::App& app, CommandLine& line) {
  CLI::App* intruder = app.add_subcommand(
      "intruder", "Place a person or object that sensors detect and nothing touches");
  intruder->require_subcommand(1);
  auto [place, command] =
      add_command<IntruderCommand>(*intruder, line, "place", "Place it on the floor, or move it");
  place
      ->add_option_function<std::array<double, 2>>(
          "XY", [c = command](const std::array<double, 2>& xy) { c->xy_m = xy; },
          "Position of its centre in the world [m]")
      ->check(finite())
      ->required();
  place->add_option("--size", command->size_m, "Extent along x, y and z [m] (default 0.5 0.3 1.75)")
      ->type_name("X Y Z")
      ->check(above_zero());
  offer_json(*place, line);
  offer_json(*add_command<IntruderCommand>(*intruder, line, "remove", "Remove it").first, line);
}

}  // namespace aprsim::client
