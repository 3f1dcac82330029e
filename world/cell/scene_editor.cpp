#include "world/cell/scene_editor.hpp"

#include <utility>
#include <variant>
#include <vector>

#include "world/cell/state_bytes.hpp"
#include "world/devices/device_group.hpp"
#include "world/scene/scene_edit.hpp"

namespace aprsim::world {
namespace {

using WorldPtr = std::unique_ptr<World>;

Result<int> find_body(const World& world, const std::string& name) {
  const auto body = world.settings().find_body(name);
  if (!body) {
    return fail(
        ErrorCode::kNotFound, "name",
        "'" + name.substr(0, api::kMaxSceneText) + "' is no gear, tray or part of the cell");
  }
  if (world.physics().body(*body).lost_step) {
    return fail(ErrorCode::kFailedPrecondition, "name",
                "'" + name + "' is not in the cell any more");
  }
  return *body;
}

Result<WorldPtr> with_value(const World& world, const api::SetSceneValue& set) {
  auto scene = scene::with_value(*world.scene(), set.path, set.value);
  if (!scene) return tl::unexpected(std::move(scene.error()));
  if (auto ok = devices::check_devices(*scene, "scene"); !ok) return tl::unexpected(ok.error());
  WorldPtr next = world.in_scene(*std::move(scene));
  // The state is the same bit for bit; the constants are those of the new scene.
  const WorldState blank = next->save();
  auto state = with_constants_of(blank, world.save());
  if (!state) {
    return fail(ErrorCode::kInvalidArgument, "path",
                "'" + set.path + "' cannot be changed while the cell runs");
  }
  if (world.watches_events()) next->watch_events();
  next->restore(*state);
  return next;
}

/// Free bodies of the scene's file, without tools.
std::size_t bodies_in(const scene::Scene& scene) {
  return scene.gears.size() + scene.trays.size() + scene.parts.size();
}

Result<WorldPtr> with_body(const World& world, const api::SpawnBody& spawn) {
  const std::size_t added = bodies_in(*world.scene()) - bodies_in(world.base_scene());
  if (added >= api::kMaxAddedBodies) {
    return fail(ErrorCode::kFailedPrecondition, "name",
                "'" + spawn.name + "': " + std::to_string(added) +
                    " bodies have been added to the cell, the limit is " +
                    std::to_string(api::kMaxAddedBodies) + " with those removed; reset the cell");
  }
  auto scene = scene::with_body(*world.scene(), spawn.type, spawn.name, spawn.X_WB);
  if (!scene) return tl::unexpected(std::move(scene.error()));
  if (auto ok = devices::check_devices(*scene, "scene"); !ok) return tl::unexpected(ok.error());
  WorldPtr next = world.in_scene(*std::move(scene));
  std::vector<int> old_of;
  int spawned = -1;
  for (const auto& body : next->settings().bodies) {
    const auto was = world.settings().find_body(body.name);
    if (!was) spawned = static_cast<int>(old_of.size());
    old_of.push_back(was.value_or(-1));
  }
  next->adopt(world, old_of);
  next->put_body(spawned, spawn.X_WB);
  if (world.watches_events()) next->watch_events();
  return next;
}

}  // namespace

Result<void> SceneEditor::apply(const api::SceneCommand& command) {
  return std::visit([this](const auto& change) { return edit(change); }, command);
}

Result<void> SceneEditor::edit(const api::SetSceneValue& set) {
  auto next = with_value(*world_, set);
  if (!next) return tl::unexpected(std::move(next.error()));
  replace_by(*std::move(next));
  report("", set.path + " = " + set.value);
  return {};
}

Result<void> SceneEditor::edit(const api::SpawnBody& spawn) {
  auto next = with_body(*world_, spawn);
  if (!next) return tl::unexpected(std::move(next.error()));
  replace_by(*std::move(next));
  report(spawn.name, "spawned");
  return {};
}

Result<void> SceneEditor::edit(const api::MoveBody& move) {
  const auto body = find_body(*world_, move.name);
  if (!body) return tl::unexpected(body.error());
  world_->put_body(*body, move.X_WB);
  report(move.name, "moved");
  return {};
}

Result<void> SceneEditor::edit(const api::RemoveBody& remove) {
  const auto body = find_body(*world_, remove.name);
  if (!body) return tl::unexpected(body.error());
  world_->remove_body(*body);
  report(remove.name, "removed");
  return {};
}

void SceneEditor::replace_by(std::unique_ptr<World> next) {
  // Events that are not published yet come first.
  if (auto* events = world_->events()) std::swap(*next->events(), *events);
  world_ = std::move(next);
}

void SceneEditor::report(const std::string& name, std::string text) {
  auto* events = world_->events();
  if (events == nullptr) return;
  api::CellEvent event{.step = world_->step_count(),
                       .time = world_->time(),
                       .kind = api::CellEventKind::kEdited,
                       .text = std::move(text)};
  if (!name.empty()) event.names.push_back(name);
  events->push_back(std::move(event));
}

Result<void> apply_command(std::unique_ptr<World>& world, api::Ticket ticket,
                           const api::Command& command) {
  const auto* change = std::get_if<api::SceneCommand>(&command.body);
  return change != nullptr ? SceneEditor(world).apply(*change) : world->apply_any(ticket, command);
}

}  // namespace aprsim::world
