#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "world/api/commands/command.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/cell/cell_vision.hpp"
#include "world/cell/cell_watch.hpp"
#include "world/cell/conveyor_drive.hpp"
#include "world/cell/robot_touches.hpp"
#include "world/cell/sensor_occluders.hpp"
#include "world/cell/simulated_robot.hpp"
#include "world/cell/world_state.hpp"
#include "world/faults/fault_effects.hpp"
#include "world/faults/fault_schedule.hpp"
#include "world/physics/physics_world.hpp"
#include "world/scene/model/scene.hpp"
#include "world/sensors/light_curtain.hpp"
#include "world/sensors/photo_eyes.hpp"

namespace aprsim::world {

/// The models of a scene's robots, in their order.
using ArmModels = std::shared_ptr<const std::vector<robot::ArmModel>>;
/// Reads them. Throws std::runtime_error naming the robot and cause.
[[nodiscard]] ArmModels load_models(const scene::Scene& scene);

/// The simulated cell, without threads or clocks: commands in, fixed steps, state out. The same
/// scene, seed and commands at the same steps give the same bits. Thread: one at a time.
class World {
 public:
  /// Throws std::runtime_error naming the robot and cause when a model cannot be used.
  /// `prefetchers`, one a robot, make motion plans ahead and must outlive the world; without them
  /// plans are made when they are needed, with the same bits.
  World(std::shared_ptr<const scene::Scene> scene, std::uint64_t seed,
        std::span<robot::PlanPrefetcher* const> prefetchers = {});
  /// The same with models that load_models() has read.
  World(std::shared_ptr<const scene::Scene> scene, ArmModels models, std::uint64_t seed,
        std::span<robot::PlanPrefetcher* const> prefetchers);

  /// Applies a command that has been checked (command_check.hpp).
  void apply(api::Ticket ticket, const api::RobotCommand& command);
  void apply(api::Ticket ticket, const api::ConveyorCommand& command);
  void apply(api::Ticket ticket, const api::SetIntruder& command);
  /// Faults begin and end at the beginning of a step. Errors: too many faults, an unknown one.
  [[nodiscard]] Result<void> apply(api::Ticket ticket, const api::FaultCommand& command);
  /// Any of these; what is asked of the simulation is none of the world's.
  [[nodiscard]] Result<void> apply_any(api::Ticket ticket, const api::Command& command);

  /// Changes the scene of the cell that it is given, which may be another world afterwards: with
  /// the same time, robots and bodies. Errors: as a scene's file has them, kNotFound for a name
  /// that nothing has; nothing has changed then.
  [[nodiscard]] static Result<void> edit(std::unique_ptr<World>& world,
                                         const api::SceneCommand& command);
  /// Applies any command that is not the simulation's own; a change of the scene as edit().
  [[nodiscard]] static Result<void> carry_out(std::unique_ptr<World>& world, api::Ticket ticket,
                                              const api::Command& command);
  [[nodiscard]] const std::shared_ptr<const scene::Scene>& scene() const { return scene_; }
  [[nodiscard]] const ArmModels& models() const { return models_; }
  /// Counts how often the description of the cell has changed; the caller's.
  void set_revision(std::uint64_t revision);

  /// Advances by one fixed step. Throws physics::PhysicsFailure when the physics fails; the state
  /// is then that of the last good step.
  void step();

  /// What the contact solver does, since this world was built.
  [[nodiscard]] const api::SolverWork& solver_work() const { return physics_->solver_work(); }

  /// From now on what happens in the cell is found at every step and command. Costs little, and
  /// changes nothing.
  void watch_events();
  /// What has happened since they were last taken, without sequence and epoch: the caller takes
  /// them. Null unless they are watched.
  [[nodiscard]] std::vector<api::CellEvent>* events();

  /// Between two steps. Allocates.
  [[nodiscard]] WorldState save() const;
  /// `state` must come from a world of the same scene; its seed is taken over.
  void restore(const WorldState& state);

  /// Whether a quantity is beyond its limit now; `robot` as resolve() has found it.
  [[nodiscard]] bool beyond(const api::WhenCrossing& crossing, int robot) const;

  [[nodiscard]] SimTime time() const;
  [[nodiscard]] std::uint64_t step_count() const { return steps_; }
  [[nodiscard]] SimTime step_size() const { return step_size_; }
  /// How often a step waited for a motion plan: a matter of the machine's load, not of the state.
  [[nodiscard]] std::uint64_t plan_waits() const;
  [[nodiscard]] const std::shared_ptr<const api::CellDescription>& description() const {
    return description_;
  }
  /// Over the bits of every free body's and joint's state.
  [[nodiscard]] std::uint64_t state_hash() const;

  /// Writes all that the world knows; leaves the fields of the simulation (epoch, pacing) alone.
  void write(api::Snapshot& out) const;

 private:
  void describe(std::uint64_t seed);
  void step_robot(std::size_t index);
  [[nodiscard]] int robot_with(int tool) const;  ///< -1 = none
  void note_touches();
  void begin_watch(CellWatch::State apart);
  [[nodiscard]] CellWatch::Now now() const { return {steps_, time()}; }
  void sense();
  void look_at_belt();
  void look_through_curtain();
  void stop_robots_if_broken();

  // ---- changes of the scene (world_edit.cpp)
  [[nodiscard]] std::unique_ptr<World> in_scene(scene::Scene scene) const;
  [[nodiscard]] Result<std::unique_ptr<World>> with_value(const api::SetSceneValue& set) const;
  [[nodiscard]] Result<std::unique_ptr<World>> with_body(const api::SpawnBody& spawn) const;
  [[nodiscard]] Result<int> find_body(const std::string& name) const;
  void adopt(const World& old, std::span<const int> old_of);
  void tell_edit(const std::string& name, std::string what);

  // ---- injected faults (faults/world_faults.cpp)
  class Facts;
  void run_faults();
  void tell_faults(const FaultSchedule::Changes& changes);
  /// What a momentary fault does; returns what there is to tell, mostly nothing.
  std::string carry_out(const FaultSpec& fault);
  std::string move_part(const FaultSpec& fault);
  std::string shift_tray(const FaultSpec& fault);
  void bring_into_effect(const FaultEffects& effects);
  void gather_intruders(std::span<const api::Intruder> of_faults);

  std::shared_ptr<const scene::Scene> scene_, base_;  // see WorldState
  std::vector<robot::PlanPrefetcher*> prefetchers_;
  std::uint64_t revision_ = 0;
  SimTime step_size_;
  std::uint64_t steps_ = 0;
  ArmModels models_;
  std::vector<SimulatedRobot> robots_;
  std::vector<LooseTool> loose_;  // that the robot at hand may take
  std::optional<ConveyorDrive> conveyor_;
  std::optional<sensors::PhotoEyes> photo_eyes_;  // there when the conveyor is
  std::optional<physics::PhysicsWorld> physics_;
  std::shared_ptr<const api::CellDescription> description_;
  std::optional<SensorOccluders> occluders_;
  std::optional<CellVision> vision_;
  std::optional<sensors::LightCurtain> light_curtain_;
  api::LightCurtainSnapshot curtain_;
  std::optional<api::Intruder> intruder_;
  FaultSchedule faults_;
  RobotTouches touches_;
  std::optional<CellWatch> watch_;        ///< none unless events are watched
  std::vector<api::Intruder> intruders_;  ///< with those of faults, which come last
};

}  // namespace aprsim::world
