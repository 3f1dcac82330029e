#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "world/api/commands/command.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/cell/cell_readings.hpp"
#include "world/cell/cell_settings.hpp"
#include "world/cell/device_view.hpp"
#include "world/cell/machines/conveyor_drive.hpp"
#include "world/cell/machines/simulated_robot.hpp"
#include "world/cell/observation/cell_surroundings.hpp"
#include "world/cell/observation/event_detector.hpp"
#include "world/cell/observation/sensor_occluders.hpp"
#include "world/cell/observation/unintended_contacts.hpp"
#include "world/cell/standstill.hpp"
#include "world/cell/world_state.hpp"
#include "world/devices/device_group.hpp"
#include "world/faults/fault_effects.hpp"
#include "world/faults/fault_schedule.hpp"
#include "world/physics/physics_world.hpp"
#include "world/scene/model/scene.hpp"
#include "world/sensors/cell_vision.hpp"
#include "world/sensors/light_curtain.hpp"
#include "world/sensors/photo_eyes.hpp"

namespace aprsim::world {

/// Reads the models of a scene's robots. Throws std::runtime_error naming the robot and cause.
[[nodiscard]] ArmModels load_models(const scene::Scene& scene);
/// The models of `scene`: those of `known`, which are `models`, where its robots have the same
/// files, else read. Throws as load_models().
[[nodiscard]] ArmModels models_for(const scene::Scene& scene, const scene::Scene& known,
                                   const ArmModels& models);

/// The simulated cell, without threads or clocks: commands in, fixed steps, state out. The same
/// scene, seed and commands at the same steps give the same bits. Thread: one at a time.
class World {
 public:
  /// Throws std::runtime_error naming the robot and cause when a model cannot be used, or the
  /// device and cause when its extension cannot. `prefetchers`, one a robot, make motion plans
  /// ahead and must outlive the world; without them plans are made when they are needed, with the
  /// same bits.
  World(std::shared_ptr<const scene::Scene> scene, std::uint64_t seed,
        std::span<robot::PlanPrefetcher* const> prefetchers = {});
  /// The same with models that load_models() has read.
  World(std::shared_ptr<const scene::Scene> scene, ArmModels models, std::uint64_t seed,
        std::span<robot::PlanPrefetcher* const> prefetchers);

  /// Applies a command that has been checked (command_check.hpp).
  void apply(api::Ticket ticket, const api::RobotCommand& command);
  /// Errors as of the command.
  [[nodiscard]] Result<void> apply(api::Ticket ticket, const api::TrajectoryCommand& command);
  void apply(api::Ticket ticket, const api::ConveyorCommand& command);
  void apply(api::Ticket ticket, const api::SetIntruder& command);
  /// Sets all of them, or none. Errors: as of devices::check_settings().
  [[nodiscard]] Result<void> apply(api::Ticket ticket, const api::SetSignals& command);
  /// Faults begin and end at the beginning of a step. Errors: too many faults, an unknown one.
  [[nodiscard]] Result<void> apply(api::Ticket ticket, const api::FaultCommand& command);
  /// Applies any of these. Commands to the simulation change nothing; for changes of the scene see
  /// apply_command() in scene_editor.hpp.
  [[nodiscard]] Result<void> apply_any(api::Ticket ticket, const api::Command& command);

  /// A move as its robot would make it now, in `mode` or in the one that is set; changes nothing.
  /// Errors: see SimulatedRobot::preview().
  [[nodiscard]] Result<std::shared_ptr<robot::MovePreview>> preview(
      const api::RobotCommand& command, std::optional<api::PlanningMode> mode) const;

  /// Advances by one fixed step. Throws physics::PhysicsFailure when the physics fails; the state
  /// is then that of the last good step.
  void step();
  /// Whether it is at rest until something acts on it: steps then advance its clocks and cameras
  /// alone, with the same bits.
  [[nodiscard]] bool stands_still() const { return standstill_.holds(); }
  /// Takes steps of a cell that is at rest, all at once.
  void step_still(std::uint64_t steps);

  // ---- changes of the scene: see SceneEditor
  /// Builds a world of a changed scene with the same robots, at step 0. Its description is the next
  /// revision.
  [[nodiscard]] std::unique_ptr<World> in_scene(scene::Scene scene) const;
  /// Takes over time and state of another world with the same robots, tools and surroundings.
  /// `old_of`: index in `old` of each body here, -1 = new.
  void adopt(const World& old, std::span<const int> old_of);
  /// Places a body at a pose, or above it by as much as it takes to be clear of all else.
  void put_body(int body, const Pose& X_WB);
  /// Removes a body from the cell: it is lost.
  void remove_body(int body);

  /// From now on, detects events at every step and command. Costs little, and changes nothing.
  void watch_events();
  [[nodiscard]] bool watches_events() const { return detector_.has_value(); }
  /// Detected events, without sequence and epoch; the caller removes them. Null unless events are
  /// watched.
  [[nodiscard]] std::vector<api::CellEvent>* events();

  /// Between two steps. Allocates.
  [[nodiscard]] WorldState save() const;
  /// `state` must come from a world of the same scene; its seed is taken over.
  void restore(const WorldState& state);

  /// Whether a quantity is beyond its limit now; `robot` as robot_of() gives it.
  [[nodiscard]] bool beyond(const api::WhenCrossing& crossing, int robot) const;

  [[nodiscard]] SimTime time() const;
  [[nodiscard]] std::uint64_t step_count() const { return steps_; }
  [[nodiscard]] SimTime step_size() const { return settings_.step_size; }
  /// Number of steps that waited for a motion plan: depends on the machine's load, no state.
  [[nodiscard]] std::uint64_t plan_waits() const;
  /// Work of the contact solver since this world was built.
  [[nodiscard]] const api::SolverWork& solver_work() const { return physics_->solver_work(); }
  /// Over the bits of every free body's and joint's state.
  [[nodiscard]] std::uint64_t state_hash() const;

  [[nodiscard]] const std::shared_ptr<const scene::Scene>& scene() const { return scene_; }
  /// The scene as it was loaded, without later changes.
  [[nodiscard]] const scene::Scene& base_scene() const { return base_ ? *base_ : *scene_; }
  [[nodiscard]] const ArmModels& models() const { return models_; }
  [[nodiscard]] const CellSettings& settings() const { return settings_; }
  [[nodiscard]] std::span<const SimulatedRobot> robots() const { return robots_; }
  [[nodiscard]] const physics::PhysicsWorld& physics() const { return *physics_; }
  /// Null = the cell has none.
  [[nodiscard]] const ConveyorDrive* conveyor() const { return conveyor_ ? &*conveyor_ : nullptr; }

  /// The cell as published to clients.
  [[nodiscard]] const std::shared_ptr<const api::CellDescription>& description() const {
    return description_;
  }
  /// Sets the count of changes of the description, which the caller keeps.
  void set_revision(std::uint64_t revision);
  /// Writes the world's fields of a snapshot; leaves those of the simulation (epoch, pacing) alone.
  void write(api::Snapshot& out) const;

 private:
  void describe();
  void write_bodies(std::vector<api::BodySnapshot>& out) const;
  void write_tools(std::vector<api::ToolSnapshot>& out) const;

  // ---- one step
  void advance();
  [[nodiscard]] bool awaits_time() const;
  [[nodiscard]] bool reads_sensors_at(std::uint64_t step) const;
  void set_surroundings() const;
  void run_faults();
  void run_devices();
  void step_robot(std::size_t index);
  void gather_loose_tools(const SimulatedRobot& robot);
  [[nodiscard]] int robot_with(int tool) const;  ///< -1 = none
  void record_unintended_contacts();
  void sense();
  void read_photo_eyes();
  void read_light_curtain();
  void stop_robots_if_broken();

  // ---- events
  void begin_detection(EventDetector::State apart);
  void report_faults(const FaultSchedule::Changes& changes);
  [[nodiscard]] EventDetector::Now now() const { return {steps_, time()}; }

  // ---- faults and intruders
  [[nodiscard]] CellReadings readings() const;
  [[nodiscard]] FaultEffects lasting_effects() const;
  void gather_intruders(std::span<const api::Intruder> of_faults);

  std::shared_ptr<const scene::Scene> scene_, base_;  // see WorldState
  std::vector<robot::PlanPrefetcher*> prefetchers_;
  ArmModels models_;
  CellSettings settings_;
  std::shared_ptr<const archive::WorldCounts> counts_;  // see WorldState
  std::uint64_t seed_;
  std::uint64_t revision_ = 0;
  std::uint64_t steps_ = 0;
  std::unique_ptr<CellSurroundings> surroundings_;
  std::vector<SimulatedRobot> robots_;
  std::vector<LooseTool> loose_;  // that the robot at hand may take
  std::optional<ConveyorDrive> conveyor_;
  std::optional<sensors::PhotoEyes> photo_eyes_;  // there when the conveyor is
  std::optional<physics::PhysicsWorld> physics_;
  std::shared_ptr<const api::CellDescription> description_;  // for publication only
  std::optional<SensorOccluders> occluders_;
  std::optional<sensors::CellVision> vision_;
  std::optional<sensors::LightCurtain> light_curtain_;
  api::LightCurtainSnapshot curtain_;
  std::optional<api::Intruder> intruder_;
  FaultSchedule faults_;
  UnintendedContacts unintended_contacts_;
  std::optional<EventDetector> detector_;  ///< none unless events are watched
  std::vector<api::Intruder> intruders_;   ///< with those of faults, which come last
  std::unique_ptr<devices::DeviceGroup> devices_;
  DeviceView device_view_;
  Standstill standstill_;
};

}  // namespace aprsim::world
