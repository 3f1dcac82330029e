#include "world/runtime/current_world.hpp"

#include <utility>

#include "world/cell/commands/next_scene.hpp"
#include "world/cell/scene_editor.hpp"

namespace aprsim::world {
CurrentWorld::CurrentWorld(std::shared_ptr<const scene::Scene> scene, std::uint64_t seed,
                           bool plans_ahead)
    : scene_at_start_(std::move(scene)),
      scene_(scene_at_start_),
      seed_(seed),
      plans_ahead_(plans_ahead),
      world_(build(scene_, load_models(*scene_), seed)) {
  world_->watch_events();
}

std::shared_ptr<const scene::Scene> CurrentWorld::scene() const {
  const std::lock_guard lock(scene_mutex_);
  return scene_;
}

void CurrentWorld::reset(const api::Reset& wanted) {
  const auto scene = wanted.next ? scene_of(*wanted.next) : scene_;
  // Another scene has a seed of its own.
  const std::uint64_t seed = wanted.seed.value_or(wanted.next ? scene->seed : seed_);
  const ArmModels models = wanted.next ? models_of(*wanted.next) : world_->models();
  auto fresh = build(scene, models, seed);
  if (scene != world_->scene()) ++revision_;
  replace(std::move(fresh));
  set_scene(scene);
  seed_ = seed;
}

Result<void> CurrentWorld::carry_out(api::Ticket ticket, const api::Command& command) {
  const World* before = world_.get();
  Result<void> done = apply_command(world_, ticket, command);
  if (world_.get() != before) world_->set_revision(++revision_);
  return done;
}

void CurrentWorld::restore(const WorldState& state) {
  if (state.scene && state.scene != world_->scene()) {
    auto other = build(state.scene, state.models, state.seed);
    ++revision_;
    replace(std::move(other));
  }
  world_->restore(state);
  seed_ = state.seed;
  if (state.scene) set_scene(state.base_scene());
}

std::unique_ptr<World> CurrentWorld::build(const std::shared_ptr<const scene::Scene>& scene,
                                           const ArmModels& models, std::uint64_t seed) {
  while (plans_ahead_ && planning_threads_.size() < models->size()) {
    planning_threads_.push_back(std::make_unique<robot::PlanningThread>());
  }
  std::vector<robot::PlanPrefetcher*> prefetchers;
  for (const auto& thread : planning_threads_) prefetchers.push_back(thread.get());
  return std::make_unique<World>(scene, models, seed, prefetchers);
}

void CurrentWorld::replace(std::unique_ptr<World> next) {
  next->set_revision(revision_);
  next->watch_events();
  world_ = std::move(next);
}

void CurrentWorld::set_scene(std::shared_ptr<const scene::Scene> scene) {
  // The former scene is destroyed outside the lock.
  const std::lock_guard lock(scene_mutex_);
  scene_.swap(scene);
}

}  // namespace aprsim::world
