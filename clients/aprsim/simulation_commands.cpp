#include <ostream>

#include <fmt/format.h>

#include "clients/aprsim/cell_connection.hpp"
#include "clients/aprsim/commands.hpp"
#include "clients/aprsim/status_text.hpp"

namespace aprsim::client {
namespace {

Outcome<void> show(const std::string& what, const Outcome<v1::Receipt>& receipt, Console& console) {
  if (!receipt) return tl::unexpected(receipt.error());
  console.out << fmt::format("{} at step {} ({:.3f} s), epoch {}\n", what, receipt->step(),
                             seconds(receipt->sim_time()), receipt->epoch());
  return {};
}

}  // namespace

Outcome<void> run_command(const PauseCommand& /*command*/, Console& console) {
  return show("paused", CellConnection(console.endpoints).pause(), console);
}

Outcome<void> run_command(const ResumeCommand& /*command*/, Console& console) {
  return show("resumed", CellConnection(console.endpoints).resume(), console);
}

Outcome<void> run_command(const StepCommand& command, Console& console) {
  return show(fmt::format("took {} step{}, now", command.steps, command.steps == 1 ? "" : "s"),
              CellConnection(console.endpoints).step(command.steps), console);
}

Outcome<void> run_command(const SpeedCommand& command, Console& console) {
  const std::string what =
      command.factor ? fmt::format("speed {} x real time", *command.factor) : "speed maximal";
  return show(what, CellConnection(console.endpoints).set_speed(command.factor), console);
}

Outcome<void> run_command(const ResetCommand& command, Console& console) {
  return show("reset", CellConnection(console.endpoints).reset(command.seed), console);
}

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
  if (response->has_light_curtain()) {
    console.out << "light curtain " << (response->light_curtain().broken() ? "broken" : "clear")
                << ", ";
  }
  return show(intruder ? "intruder put" : "intruder removed", response->receipt(), console);
}

Outcome<void> run_command(const SaveCommand& command, Console& console) {
  return show(fmt::format("saved '{}'", command.name),
              CellConnection(console.endpoints).save_state(command.name), console);
}

Outcome<void> run_command(const LoadCommand& command, Console& console) {
  return show(fmt::format("loaded '{}'", command.name),
              CellConnection(console.endpoints).load_state(command.name), console);
}

}  // namespace aprsim::client
