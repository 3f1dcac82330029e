#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "world/api/values/light_curtain.hpp"
#include "world/archive/world_counts.hpp"
#include "world/cell/machines/conveyor_drive.hpp"
#include "world/cell/machines/simulated_robot.hpp"
#include "world/cell/observation/event_detector.hpp"
#include "world/cell/observation/unintended_contacts.hpp"
#include "world/devices/device_state.hpp"
#include "world/faults/fault_schedule.hpp"
#include "world/physics/physics_world.hpp"
#include "world/scene/model/scene.hpp"
#include "world/sensors/cell_vision.hpp"
#include "world/sensors/photo_eyes.hpp"

namespace aprsim::world {

/// The models of a scene's robots, in their order.
using ArmModels = std::shared_ptr<const std::vector<robot::ArmModel>>;

/// The state of a world, as copyable values. Restored in a world of the same scene, it continues
/// bit for bit like the original.
struct WorldState {
  static constexpr std::uint64_t kMaxSteps = 100'000'000'000;

  std::shared_ptr<const scene::Scene> scene;           ///< of the world
  std::shared_ptr<const scene::Scene> base;            ///< before changes; null = not changed
  ArmModels models;                                    ///< of the world's robots
  std::shared_ptr<const archive::WorldCounts> counts;  ///< of the world; bounds of indices
  std::uint64_t seed = 0;
  std::uint64_t steps = 0;
  std::vector<SimulatedRobot::State> robots;
  std::optional<ConveyorDrive> conveyor;
  std::optional<sensors::PhotoEyes> photo_eyes;
  physics::PhysicsWorld::State physics;
  std::optional<sensors::CellVision> vision;
  api::LightCurtainSnapshot curtain;
  std::optional<api::Intruder> intruder;
  FaultSchedule faults;
  UnintendedContacts unintended_contacts;
  std::vector<devices::DeviceState> devices;
  EventDetector::State apart;  ///< of a world whose events are watched

  /// Memory without shared parts, approximately.
  [[nodiscard]] std::uint64_t bytes() const {
    std::uint64_t sum = sizeof *this + physics.bytes() + faults.bytes() +
                        apart.capacity() * sizeof(EventDetector::SeparatedContact);
    for (const auto& robot : robots) sum += robot.bytes();
    for (const auto& device : devices) sum += device.bytes();
    return sum;
  }
  /// The scene as it was loaded.
  [[nodiscard]] const std::shared_ptr<const scene::Scene>& base_scene() const {
    return base ? base : scene;
  }
  /// Adds the parts that copies share: the plans of motions.
  void list(robot::SharedParts& parts) const {
    for (const auto& robot : robots) robot.controller.list(parts);
  }

  /// Advances its clocks by one step of a cell that is at rest.
  void advance_clocks(double step_s, SimTime step_size) {
    ++steps;
    for (auto& robot : robots) robot.own.now += step_size;
    if (conveyor) conveyor->advance_clock(step_s, 1);
    physics.advance_clock(1);
  }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [scene, base, models, counts, seed, steps, robots, conveyor, photo_eyes, physics, vision,
           curtain, intruder, faults, unintended_contacts, devices, apart] = self;
    io(seed, steps, robots, conveyor, photo_eyes, physics, vision, curtain, intruder, faults,
       unintended_contacts, devices, apart);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.one_for_each(In::kRobot, robots.size());
    in.require(steps <= kMaxSteps, "more steps than a clock can count");
    for (std::size_t r = 0; r < robots.size(); ++r) {
      in.require(robots[r].own.mount.tool() == physics.tool_of(static_cast<int>(r)),
                 "a robot and its flange with different tools");
    }
  }
};

}  // namespace aprsim::world
