#pragma once

#include <optional>
#include <span>
#include <string>

#include "world/cell/cell_settings.hpp"
#include "world/cell/machines/conveyor_drive.hpp"
#include "world/cell/machines/simulated_robot.hpp"
#include "world/faults/fault_schedule.hpp"
#include "world/physics/physics_world.hpp"
#include "world/sensors/photo_eyes.hpp"

namespace aprsim::world {

/// Reads from a cell the values that triggers of faults and conditions of runs refer to. A view:
/// valid while the parts that it was given live. Thread: theirs.
class CellReadings final : public CellFacts {
 public:
  /// Null conveyor and photo-eyes = the cell has none.
  CellReadings(const CellSettings& settings, std::span<const SimulatedRobot> robots,
               const physics::PhysicsWorld& physics, const ConveyorDrive* conveyor,
               const sensors::PhotoEyes* photo_eyes);

  [[nodiscard]] int robots() const override { return static_cast<int>(robots_.size()); }
  [[nodiscard]] GripFacts grip(int robot) const override;
  [[nodiscard]] const std::string& type_of(int body) const override;
  [[nodiscard]] bool beam_broken(int eye) const override;
  [[nodiscard]] double quantity(faults::Quantity quantity, int robot, int joint) const override;
  [[nodiscard]] std::optional<double> distance_to_belt_end(int body) const override;

 private:
  [[nodiscard]] const SimulatedRobot& robot_at(int index) const {
    return robots_[static_cast<std::size_t>(index)];
  }

  const CellSettings& settings_;
  std::span<const SimulatedRobot> robots_;
  const physics::PhysicsWorld& physics_;
  const ConveyorDrive* conveyor_;
  const sensors::PhotoEyes* photo_eyes_;
};

}  // namespace aprsim::world
