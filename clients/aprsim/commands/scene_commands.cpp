#include "clients/aprsim/commands/scene_commands.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <ostream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/commands/file_commands.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/commands/receipt_text.hpp"
#include "clients/aprsim/text/event_text.hpp"
#include "clients/wires/cell_connection.hpp"

namespace aprsim::client {
namespace {

void write_place(const std::array<double, 3>& at_m, double yaw_deg, v1::Pose& pose) {
  pose.mutable_position_m()->set_x(at_m[0]);
  pose.mutable_position_m()->set_y(at_m[1]);
  pose.mutable_position_m()->set_z(at_m[2]);
  const double half_rad = yaw_deg * std::numbers::pi / 360;
  pose.mutable_orientation()->set_w(std::cos(half_rad));
  pose.mutable_orientation()->set_z(std::sin(half_rad));
}

/// The pose of a placed body, which may be higher than requested.
template <typename Response>
Outcome<void> show_body(const char* done, const std::string& what, const std::string& name,
                        const Outcome<Response>& response, Console& console) {
  if (!response) return tl::unexpected(response.error());
  const auto& at = response->body().body_in_world().position_m();
  return show_receipt(
      done, fmt::format("{} {} at {:.4f} {:.4f} {:.4f} m,", what, name, at.x(), at.y(), at.z()),
      response->receipt(), console, {{"name", name}, {"at_m", {at.x(), at.y(), at.z()}}});
}

template <typename Command>
void add_place(CLI::App& app, const std::shared_ptr<Command>& command) {
  app.add_option("--at", command->at_m, "Position of its origin in the world [m]")
      ->type_name("X Y Z")
      ->check(within(-1000, 1000))
      ->required();
  app.add_option("--yaw", command->yaw_deg, "Rotation about the vertical [deg] (default 0)")
      ->type_name("DEGREES")
      ->check(within(-360, 360));
}

}  // namespace

Outcome<void> run_command(const SceneShowCommand& /*command*/, Console& console) {
  const auto scene = CellConnection(console.endpoints).scene();
  if (!scene) return tl::unexpected(scene.error());
  if (!console.json && !console.screen.live) {
    // Redirected to a file, the text must stay unchanged.
    console.write(scene->text());
    return {};
  }
  console.show(scene->text(),
               {{"name", scene->name()}, {"revision", scene->revision()}, {"text", scene->text()}});
  return {};
}

Outcome<void> run_command(const SceneListCommand& /*command*/, Console& console) {
  const auto snapshot = CellConnection(console.endpoints).snapshot();
  if (!snapshot) return tl::unexpected(snapshot.error());
  for (const auto& body : snapshot->bodies()) {
    const auto& at = body.body_in_world().position_m();
    const bool lost = body.has_lost_step();
    const std::string where =
        lost ? "lost" : fmt::format("{:8.4f} {:8.4f} {:8.4f} m", at.x(), at.y(), at.z());
    console.show(fmt::format("{:<28} {:<28} {}\n", body.name(), body.type(), where),
                 {{"name", body.name()},
                  {"type", body.type()},
                  {"at_m", {at.x(), at.y(), at.z()}},
                  {"lost", lost}});
  }
  return {};
}

Outcome<void> run_command(const SceneTypesCommand& /*command*/, Console& console) {
  const auto cell = CellConnection(console.endpoints).cell();
  if (!cell) return tl::unexpected(cell.error());
  for (const auto& type : cell->body_types()) console.show(type + "\n", {{"type", type}});
  return {};
}

Outcome<void> run_command(const SceneSpawnCommand& command, Console& console) {
  v1::SpawnBodyRequest request;
  request.set_type(command.type);
  request.set_name(command.name);
  write_place(command.at_m, command.yaw_deg, *request.mutable_body_in_world());
  return show_body("scene spawn", "put down", command.name,
                   CellConnection(console.endpoints).spawn_body(request), console);
}

Outcome<void> run_command(const SceneMoveCommand& command, Console& console) {
  v1::MoveBodyRequest request;
  request.set_name(command.name);
  write_place(command.at_m, command.yaw_deg, *request.mutable_body_in_world());
  return show_body("scene move", "moved", command.name,
                   CellConnection(console.endpoints).move_body(request), console);
}

Outcome<void> run_command(const SceneRemoveCommand& command, Console& console) {
  return show_receipt("scene remove", "took out " + command.name + ",",
                      CellConnection(console.endpoints).remove_body(command.name), console,
                      {{"name", command.name}});
}

Outcome<void> run_command(const SceneSetCommand& command, Console& console) {
  return show_receipt(
      "scene set", fmt::format("{} = {}", command.path, command.value),
      CellConnection(console.endpoints).set_scene_value(command.path, command.value), console,
      {{"path", command.path}, {"value", command.value}});
}

void add_scene(CLI::App& app, CommandLine& line) {
  CLI::App* scene =
      app.add_subcommand("scene", "Show and change the running scene, and work with scene files");
  scene->require_subcommand(1);
  offer_json(*add_command<SceneShowCommand>(*scene, line, "show", "Print the scene as YAML").first,
             line);
  offer_json(*add_command<SceneListCommand>(*scene, line, "list", "List the gears and trays").first,
             line);
  offer_json(
      *add_command<SceneTypesCommand>(*scene, line, "types", "List the types of gears and trays")
           .first,
      line);
  const auto name = [](CLI::App& sub, std::string& to) {
    sub.add_option("NAME", to, "Name of the gear or tray")->check(not_empty())->required();
  };
  auto [spawn, spawn_command] =
      add_command<SceneSpawnCommand>(*scene, line, "spawn", "Add a gear or tray");
  spawn->add_option("TYPE", spawn_command->type, "Type of the gear or tray")
      ->check(not_empty())
      ->required();
  name(*spawn, spawn_command->name);
  add_place(*spawn, spawn_command);
  offer_json(*spawn, line);
  auto [move, move_command] =
      add_command<SceneMoveCommand>(*scene, line, "move", "Move a gear or tray");
  name(*move, move_command->name);
  add_place(*move, move_command);
  offer_json(*move, line);
  auto [remove, remove_command] = add_command<SceneRemoveCommand>(
      *scene, line, "remove", "Remove a gear or tray until a reset");
  name(*remove, remove_command->name);
  offer_json(*remove, line);
  auto [set, set_command] = add_command<SceneSetCommand>(
      *scene, line, "set",
      "Set a value of physics, types or cameras, such as physics.friction.gear_tray");
  set->add_option("PATH", set_command->path, "Path of keys, separated by dots")
      ->check(not_empty())
      ->required();
  set->add_option("VALUE", set_command->value, "Value in the syntax of scene files")
      ->check(not_empty())
      ->required();
  offer_json(*set, line);
  add_scene_check(*scene, line);
  add_file_commands(*scene, line, FileKind::kScene);
}

}  // namespace aprsim::client
