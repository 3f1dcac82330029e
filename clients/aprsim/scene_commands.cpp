#include <array>
#include <cmath>
#include <numbers>
#include <ostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cell_connection.hpp"
#include "clients/aprsim/commands.hpp"
#include "clients/aprsim/event_text.hpp"
#include "clients/aprsim/receipt_text.hpp"

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

/// Where a body has been put, which may be higher than was asked for.
template <typename Response>
Outcome<void> show_body(const char* done, const std::string& what, const std::string& name,
                        const Outcome<Response>& response, Console& console) {
  if (!response) return tl::unexpected(response.error());
  const auto& at = response->body().body_in_world().position_m();
  return show_receipt(
      done, fmt::format("{} {} at {:.4f} {:.4f} {:.4f} m,", what, name, at.x(), at.y(), at.z()),
      response->receipt(), console, {{"name", name}, {"at_m", {at.x(), at.y(), at.z()}}});
}

v1::RunUntilRequest request_of(const RunCommand& command) {
  v1::RunUntilRequest request;
  request.set_max_steps(command.steps);
  if (command.time_s) {
    const double whole = std::floor(*command.time_s);
    request.mutable_time()->set_seconds(static_cast<std::int64_t>(whole));
    request.mutable_time()->set_nanos(
        static_cast<std::int32_t>(std::lround((*command.time_s - whole) * 1e9)));
  } else if (!command.kinds.empty()) {
    for (const auto& word : command.kinds) {
      if (const auto kind = event_kind(word)) request.mutable_event()->add_kinds(*kind);
    }
    for (const auto& name : command.names) request.mutable_event()->add_names(name);
  } else if (command.beyond) {
    auto& crossing = *request.mutable_crossing();
    crossing.set_quantity(command.beyond->quantity);
    crossing.set_robot(command.beyond->robot);
    crossing.set_joint(command.beyond->joint);
    if (command.beyond->above) {
      crossing.set_above(command.beyond->limit);
    } else {
      crossing.set_below(command.beyond->limit);
    }
  }
  return request;
}

}  // namespace

Outcome<void> run_command(const RunCommand& command, Console& console) {
  const auto response = CellConnection(console.endpoints).run_until(request_of(command));
  if (!response) return tl::unexpected(response.error());
  const bool met = response->outcome() == v1::RUN_OUTCOME_MET;
  std::string what = met ? "the condition holds, paused" : "took all steps, paused";
  if (response->has_event()) what = event_line(response->event()) + "\npaused";
  return show_receipt("run", what, response->receipt(), console, {{"met", met}});
}

Outcome<void> run_command(const SceneShowCommand& /*command*/, Console& console) {
  const auto scene = CellConnection(console.endpoints).scene();
  if (!scene) return tl::unexpected(scene.error());
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

}  // namespace aprsim::client
