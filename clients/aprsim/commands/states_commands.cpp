#include "clients/aprsim/commands/states_commands.hpp"

#include <fstream>
#include <iterator>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/commands/receipt_text.hpp"
#include "clients/aprsim/text/status_text.hpp"
#include "clients/wires/cell_connection.hpp"
#include "world/base/files/draft_file.hpp"

namespace aprsim::client {
namespace {

double megabytes(std::uint64_t bytes) { return static_cast<double>(bytes) / (1U << 20U); }

}  // namespace

Outcome<void> run_command(const SaveCommand& command, Console& console) {
  CellConnection cell(console.endpoints);
  const auto saved = cell.save_state(command.name);
  if (!saved || command.file.empty()) {
    return show_receipt("save", fmt::format("saved '{}'", command.name), saved, console);
  }
  const auto bytes = cell.export_state(command.name);
  if (!bytes) return tl::unexpected(bytes.error());
  files::DraftFile file(command.file);
  file.out() << *bytes;
  if (auto written = file.commit(); !written) {
    return failed(FailureKind::kUsage, written.error().message);
  }
  return show_receipt(
      "save",
      fmt::format("saved '{}', also in {} ({} bytes),", command.name, command.file, bytes->size()),
      saved, console, {{"file", command.file}, {"bytes", bytes->size()}});
}

Outcome<void> run_command(const LoadCommand& command, Console& console) {
  CellConnection cell(console.endpoints);
  std::string name = command.name;
  if (!command.file.empty()) {
    std::ifstream file(command.file, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(file), {});
    if (!file) return failed(FailureKind::kUsage, command.file + ": it cannot be read");
    const auto kept = cell.import_state(name, bytes);
    if (!kept) {
      return failed(kept.error().kind, command.file + ": " + kept.error().message);
    }
    name = kept->name();
  }
  return show_receipt("load", fmt::format("loaded '{}'", name), cell.load_state(name), console,
                      {{"name", name}});
}

Outcome<void> run_command(const StatesListCommand& /*command*/, Console& console) {
  const auto listed = CellConnection(console.endpoints).list_states();
  if (!listed) return tl::unexpected(listed.error());
  std::string text;
  auto states = nlohmann::ordered_json::array();
  for (const v1::SavedState& state : listed->states()) {
    const double time_s = seconds(state.sim_time());
    text += fmt::format("{:<24} step {:>10} {:>12.3f} s {:>8.1f} MB\n", state.name(), state.step(),
                        time_s, megabytes(state.bytes()));
    states.push_back({{"name", state.name()},
                      {"step", state.step()},
                      {"sim_time_s", time_s},
                      {"bytes", state.bytes()}});
  }
  text += fmt::format("{} saved, {:.1f} of {:.0f} MB\n", listed->states_size(),
                      megabytes(listed->bytes()), megabytes(listed->max_bytes()));
  console.show(
      text, {{"states", states}, {"bytes", listed->bytes()}, {"max_bytes", listed->max_bytes()}});
  return {};
}

Outcome<void> run_command(const StatesDeleteCommand& command, Console& console) {
  const auto deleted = CellConnection(console.endpoints).delete_state(command.name);
  if (!deleted) return tl::unexpected(deleted.error());
  console.show(fmt::format("deleted '{}'\n", command.name),
               {{"done", "states delete"}, {"name", command.name}});
  return {};
}

void add_states(CLI::App& app, CommandLine& line) {
  auto [save, save_command] = add_command<SaveCommand>(
      app, line, "save", "Save the state of the cell under a name, in the daemon");
  save->add_option("NAME", save_command->name, "Name of the state")->check(not_empty())->required();
  save->add_option("--file", save_command->file, "Also write the state to this file")
      ->type_name("FILE")
      ->check(not_empty());
  offer_json(*save, line);
  auto [load, load_command] =
      add_command<LoadCommand>(app, line, "load", "Continue from a saved state");
  auto* name =
      load->add_option("NAME", load_command->name,
                       "Name of the state; with --file its new name (default: the saved one)");
  name->check(not_empty());
  load->add_option("--file", load_command->file, "File that 'save --file' wrote")
      ->type_name("FILE")
      ->check(not_empty());
  load->callback([&line, load_command = load_command] {
    if (load_command->name.empty() && load_command->file.empty()) {
      throw CLI::RequiredError("NAME or --file FILE");
    }
    line.command = *load_command;
  });
  offer_json(*load, line);
  CLI::App* states = app.add_subcommand("states", "List and delete saved states");
  states->require_subcommand(1);
  auto [list, list_command] = add_command<StatesListCommand>(
      *states, line, "list", "List names, times and memory of saved states");
  offer_json(*list, line);
  auto [remove, command] =
      add_command<StatesDeleteCommand>(*states, line, "delete", "Delete a saved state");
  remove->add_option("NAME", command->name, "Name of the state")->check(not_empty())->required();
  offer_json(*remove, line);
}

}  // namespace aprsim::client
