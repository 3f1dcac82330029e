#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "world/api/commands/command.hpp"
#include "world/cell/world.hpp"
#include "world/robot/planning/plan_job.hpp"

namespace aprsim::world {

/// The world that is simulated, and its replacement by another one: on a reset, a change of the
/// scene, or a load. Thread: sim, unless said otherwise.
class CurrentWorld {
 public:
  /// `plans_ahead`: as in SimulationOptions. Throws std::runtime_error as World does.
  CurrentWorld(std::shared_ptr<const scene::Scene> scene, std::uint64_t seed, bool plans_ahead);

  [[nodiscard]] World& operator*() { return *world_; }
  [[nodiscard]] const World& operator*() const { return *world_; }
  [[nodiscard]] World* operator->() { return world_.get(); }
  [[nodiscard]] const World* operator->() const { return world_.get(); }

  [[nodiscard]] std::uint64_t seed() const { return seed_; }
  /// The scene as it was loaded last, without changes of the running cell. Thread: any.
  [[nodiscard]] std::shared_ptr<const scene::Scene> scene() const;
  /// Thread: any.
  [[nodiscard]] const scene::Scene& scene_at_start() const { return *scene_at_start_; }

  /// Builds the world anew, from the reset's scene if it has one. Throws as World does; the old
  /// world stays then.
  void reset(const api::Reset& wanted);
  /// Applies a command that is not the simulation's own. Errors: as apply_command().
  [[nodiscard]] Result<void> carry_out(api::Ticket ticket, const api::Command& command);
  /// Continues from a state, with its scene and seed. Throws when it does not fit.
  void restore(const WorldState& state);

 private:
  [[nodiscard]] std::unique_ptr<World> build(const std::shared_ptr<const scene::Scene>& scene,
                                             const ArmModels& models, std::uint64_t seed);
  void replace(std::unique_ptr<World> next);
  void set_scene(std::shared_ptr<const scene::Scene> scene);

  const std::shared_ptr<const scene::Scene> scene_at_start_;
  mutable std::mutex scene_mutex_;  ///< held to copy a pointer
  std::shared_ptr<const scene::Scene> scene_;
  std::uint64_t seed_;
  std::uint64_t revision_ = 0;  ///< of the cell's description
  const bool plans_ahead_;
  /// One for each robot of the scene with the most robots so far; they outlive its worlds.
  std::vector<std::unique_ptr<robot::PlanningThread>> planning_threads_;
  std::unique_ptr<World> world_;
};

}  // namespace aprsim::world
