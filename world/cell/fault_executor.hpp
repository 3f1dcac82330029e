#pragma once

#include <span>
#include <string>

#include "world/cell/cell_settings.hpp"
#include "world/cell/machines/conveyor_drive.hpp"
#include "world/cell/machines/simulated_robot.hpp"
#include "world/faults/fault_check.hpp"
#include "world/faults/fault_effects.hpp"
#include "world/physics/physics_world.hpp"
#include "world/sensors/cell_vision.hpp"
#include "world/sensors/photo_eyes.hpp"

namespace aprsim::world {

/// The parts of a cell that injected faults act on.
struct FaultyParts {
  const CellSettings& settings;
  std::span<SimulatedRobot> robots;
  physics::PhysicsWorld& physics;
  ConveyorDrive* conveyor;         ///< null = the cell has none
  sensors::PhotoEyes* photo_eyes;  ///< null = the cell has none
  sensors::CellVision& vision;
};

/// Carries out injected faults in a cell, between two steps. A view: valid while the parts live.
/// Thread: theirs.
class FaultExecutor {
 public:
  explicit FaultExecutor(const FaultyParts& parts) : parts_(parts) {}

  /// Carries out a fault that has just begun, if it is momentary. Returns a note for the fault's
  /// record: the reason if nothing could be done, else empty.
  [[nodiscard]] std::string carry_out(const FaultSpec& fault);

  /// Sets the effects of all lasting faults together, in place of the earlier ones. Intruders are
  /// the caller's.
  void apply(const FaultEffects& effects);

 private:
  [[nodiscard]] std::string remove_part(const FaultSpec& fault);
  [[nodiscard]] std::string swap_parts(const FaultSpec& fault);
  [[nodiscard]] std::string move_part(const FaultSpec& fault);
  [[nodiscard]] std::string shift_tray(const FaultSpec& fault);
  void put(int body, const Eigen::Isometry3d& X_WB);

  FaultyParts parts_;
};

}  // namespace aprsim::world
