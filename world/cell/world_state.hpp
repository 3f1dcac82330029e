#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "world/api/values/light_curtain.hpp"
#include "world/cell/machines/conveyor_drive.hpp"
#include "world/cell/machines/simulated_robot.hpp"
#include "world/cell/observation/event_detector.hpp"
#include "world/cell/observation/unintended_contacts.hpp"
#include "world/faults/fault_schedule.hpp"
#include "world/physics/physics_world.hpp"
#include "world/scene/model/scene.hpp"
#include "world/sensors/cell_vision.hpp"
#include "world/sensors/photo_eyes.hpp"

namespace aprsim::world {

/// All of a world that changes from step to step, as copyable values. Put back into a world of the
/// same scene, it continues bit for bit as the world did that it was saved from.
struct WorldState {
  std::shared_ptr<const scene::Scene> scene;  ///< of which it is a state
  std::shared_ptr<const scene::Scene> base;   ///< as it was before changes; null = there were none
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
  EventDetector::State apart;  ///< of a world whose events are watched

  /// Of memory, besides what copies share; approximately.
  [[nodiscard]] std::uint64_t bytes() const {
    std::uint64_t sum = sizeof *this + physics.bytes() + faults.bytes() +
                        apart.capacity() * sizeof(EventDetector::SeparatedContact);
    for (const auto& robot : robots) sum += robot.bytes();
    return sum;
  }
  /// The scene as it was loaded.
  [[nodiscard]] const std::shared_ptr<const scene::Scene>& base_scene() const {
    return base ? base : scene;
  }
  /// Adds what copies share: the plans of motions.
  void list(robot::SharedParts& parts) const {
    for (const auto& robot : robots) robot.controller.list(parts);
  }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [scene, base, seed, steps, robots, conveyor, photo_eyes, physics, vision, curtain,
           intruder, faults, unintended_contacts, apart] = self;
    io(seed, steps, robots, conveyor, photo_eyes, physics, vision, curtain, intruder, faults,
       unintended_contacts, apart);
  }
};

}  // namespace aprsim::world
