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

}  // namespace aprsim::client
