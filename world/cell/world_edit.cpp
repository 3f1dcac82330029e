// Changes of the scene while the cell goes on: another world takes over all that the old one is.

#include <algorithm>
#include <array>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "world/api/snapshot/snapshot_fields.hpp"
#include "world/archive/archive.hpp"
#include "world/cell/state_bytes.hpp"
#include "world/cell/world.hpp"
#include "world/scene/scene_edit.hpp"

namespace aprsim::world {
namespace {

/// The state of `from` in a part whose constants are its own scene's.
template <typename Part>
void hand_over(const Part& from, Part& to) {
  std::string bytes;
  archive::Writer out(bytes);
  out(from);
  archive::Reader in(bytes);
  in(to);
}

}  // namespace

void World::set_revision(std::uint64_t revision) {
  if (revision_ == revision) return;
  revision_ = revision;
  describe(description_->seed);
}

std::unique_ptr<World> World::in_scene(scene::Scene scene) const {
  auto world = std::make_unique<World>(std::make_shared<const scene::Scene>(std::move(scene)),
                                       models_, description_->seed, prefetchers_);
  world->base_ = base_ ? base_ : scene_;
  world->set_revision(revision_ + 1);
  return world;
}

Result<int> World::find_body(const std::string& name) const {
  const auto& bodies = description_->bodies;
  const auto found = std::ranges::find(bodies, name, &api::BodyDescription::name);
  if (found == bodies.end()) {
    return fail(ErrorCode::kNotFound, "name",
                "'" + name.substr(0, api::kMaxSceneText) + "' is no gear or tray of the cell");
  }
  const int body = static_cast<int>(found - bodies.begin());
  if (physics_->body(body).lost_step) {
    return fail(ErrorCode::kFailedPrecondition, "name",
                "'" + name + "' is not in the cell any more");
  }
  return body;
}

Result<std::unique_ptr<World>> World::with_value(const api::SetSceneValue& set) const {
  auto scene = scene::with_value(*scene_, set.path, set.value);
  if (!scene) return tl::unexpected(std::move(scene.error()));
  std::unique_ptr<World> next = in_scene(*std::move(scene));
  // What is state goes on bit for bit; what is the scene's is that of the new one.
  const WorldState blank = next->save();
  auto state = from_bytes(to_bytes(save()), blank);
  if (!state) {
    return fail(ErrorCode::kInvalidArgument, "path",
                "'" + set.path + "' cannot be changed while the cell runs");
  }
  if (watch_) next->watch_events();
  next->restore(*state);
  return next;
}

Result<std::unique_ptr<World>> World::with_body(const api::SpawnBody& spawn) const {
  auto scene = scene::with_body(*scene_, spawn.type, spawn.name, spawn.X_WB);
  if (!scene) return tl::unexpected(std::move(scene.error()));
  std::unique_ptr<World> next = in_scene(*std::move(scene));
  const auto& bodies = description_->bodies;
  std::vector<int> old_of;
  int added = -1;
  for (const auto& body : next->description_->bodies) {
    const auto was = std::ranges::find(bodies, body.name, &api::BodyDescription::name);
    if (was == bodies.end()) added = static_cast<int>(old_of.size());
    old_of.push_back(was == bodies.end() ? -1 : static_cast<int>(was - bodies.begin()));
  }
  next->adopt(*this, old_of);
  const std::array<physics::PhysicsWorld::Placement, 1> place{{{added, spawn.X_WB.isometry()}}};
  next->physics_->put(place);
  if (watch_) next->watch_events();
  return next;
}

void World::adopt(const World& old, std::span<const int> old_of) {
  std::vector<int> new_of(old.description_->bodies.size(), -1);
  for (std::size_t i = 0; i < old_of.size(); ++i) {
    if (old_of[i] >= 0) new_of[static_cast<std::size_t>(old_of[i])] = static_cast<int>(i);
  }
  steps_ = old.steps_;
  for (std::size_t i = 0; i < robots_.size(); ++i) robots_[i].restore(old.robots_[i].save());
  physics_->adopt(*old.physics_, old_of);
  if (conveyor_) hand_over(*old.conveyor_, *conveyor_);
  if (photo_eyes_) hand_over(*old.photo_eyes_, *photo_eyes_);
  hand_over(*old.vision_, *vision_);
  vision_->renumber(new_of);
  curtain_ = old.curtain_;
  intruder_ = old.intruder_;
  faults_ = old.faults_;
  faults_.renumber(new_of);
  touches_ = old.touches_;
  touches_.renumber(new_of);
  gather_intruders(effects_of(faults_.active(), time(), *description_).intruders);
}

void World::tell_edit(const std::string& name, std::string what) {
  if (!watch_) return;
  api::CellEvent event{.kind = api::CellEventKind::kEdited, .text = std::move(what)};
  if (!name.empty()) event.names.push_back(name);
  watch_->add(now(), std::move(event));
}

Result<void> World::carry_out(std::unique_ptr<World>& world, api::Ticket ticket,
                              const api::Command& command) {
  const auto* change = std::get_if<api::SceneCommand>(&command.body);
  return change != nullptr ? edit(world, *change) : world->apply_any(ticket, command);
}

Result<void> World::edit(std::unique_ptr<World>& world, const api::SceneCommand& command) {
  const auto replace = [&world](Result<std::unique_ptr<World>> next) -> Result<void> {
    if (!next) return tl::unexpected(std::move(next.error()));
    if (world->watch_) {
      // What has been found and not been taken yet comes first.
      std::swap((*next)->watch_->found(), world->watch_->found());
    }
    world = *std::move(next);
    return {};
  };
  if (const auto* set = std::get_if<api::SetSceneValue>(&command)) {
    if (auto done = replace(world->with_value(*set)); !done) return done;
    world->tell_edit("", set->path + " = " + set->value);
    return {};
  }
  if (const auto* spawn = std::get_if<api::SpawnBody>(&command)) {
    if (auto done = replace(world->with_body(*spawn)); !done) return done;
    world->tell_edit(spawn->name, "spawned");
    return {};
  }
  if (const auto* move = std::get_if<api::MoveBody>(&command)) {
    const auto body = world->find_body(move->name);
    if (!body) return tl::unexpected(body.error());
    const std::array<physics::PhysicsWorld::Placement, 1> place{{{*body, move->X_WB.isometry()}}};
    world->physics_->put(place);
    world->tell_edit(move->name, "moved");
    return {};
  }
  const auto& remove = std::get<api::RemoveBody>(command);
  const auto body = world->find_body(remove.name);
  if (!body) return tl::unexpected(body.error());
  world->physics_->take_away(*body);
  world->tell_edit(remove.name, "removed");
  return {};
}

}  // namespace aprsim::world
