#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cell_connection.hpp"
#include "clients/aprsim/commands.hpp"
#include "clients/aprsim/receipt_text.hpp"
#include "clients/aprsim/status_text.hpp"

namespace aprsim::client {
Outcome<void> run_command(const PauseCommand& /*command*/, Console& console) {
  return show_receipt("pause", "paused", CellConnection(console.endpoints).pause(), console);
}

Outcome<void> run_command(const ResumeCommand& /*command*/, Console& console) {
  return show_receipt("resume", "resumed", CellConnection(console.endpoints).resume(), console);
}

Outcome<void> run_command(const StepCommand& command, Console& console) {
  return show_receipt(
      "step", fmt::format("took {} step{}, now", command.steps, command.steps == 1 ? "" : "s"),
      CellConnection(console.endpoints).step(command.steps), console);
}

Outcome<void> run_command(const SpeedCommand& command, Console& console) {
  const std::string what =
      command.factor ? fmt::format("speed {} x real time", *command.factor) : "speed maximal";
  return show_receipt("speed", what, CellConnection(console.endpoints).set_speed(command.factor),
                      console);
}

Outcome<void> run_command(const ResetCommand& command, Console& console) {
  v1::ResetRequest request;
  if (command.seed) request.set_seed(*command.seed);
  if (std::filesystem::is_regular_file(command.scene)) {
    std::ifstream file(command.scene, std::ios::binary);
    request.set_scene_text(std::string(std::istreambuf_iterator<char>(file), {}));
    if (!file) return failed(FailureKind::kUsage, command.scene + " cannot be read");
  } else if (!command.scene.empty()) {
    request.set_scene_name(command.scene);
  }
  return show_receipt("reset", "reset", CellConnection(console.endpoints).reset(request), console);
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
  std::string what = intruder ? "intruder put" : "intruder removed";
  auto fields = nlohmann::ordered_json::object();
  if (response->has_light_curtain()) {
    const char* state = response->light_curtain().broken() ? "broken" : "clear";
    what = fmt::format("light curtain {}, {}", state, what);
    fields["light_curtain"] = state;
  }
  return show_receipt(intruder ? "intruder put" : "intruder remove", what, response->receipt(),
                      console, fields);
}

Outcome<void> run_command(const SaveCommand& command, Console& console) {
  CellConnection cell(console.endpoints);
  const auto saved = cell.save_state(command.name);
  if (!saved || command.file.empty()) {
    return show_receipt("save", fmt::format("saved '{}'", command.name), saved, console);
  }
  const auto bytes = cell.export_state(command.name);
  if (!bytes) return tl::unexpected(bytes.error());
  std::ofstream file(command.file, std::ios::binary);
  file << *bytes;
  if (!file.flush()) {
    return failed(FailureKind::kUsage, command.file + ": it cannot be written");
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

}  // namespace aprsim::client
