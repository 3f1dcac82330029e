#pragma once

#include <span>

#include "world/base/time.hpp"
#include "world/cell/machines/conveyor_drive.hpp"
#include "world/cell/machines/simulated_robot.hpp"
#include "world/devices/action.hpp"
#include "world/physics/physics_world.hpp"

namespace aprsim::world {

/// Carries out the actions of devices at the start of a step. Thread: the world's.
class DeviceExecutor {
 public:
  struct Parts {
    std::span<SimulatedRobot> robots;
    physics::PhysicsWorld& physics;
    ConveyorDrive* conveyor = nullptr;  ///< null = the cell has none
    double step_s = 0;
  };
  explicit DeviceExecutor(const Parts& parts) : parts_(parts) {}

  void carry_out(const devices::Action& action);

 private:
  void act(const devices::RunBelt& run);
  void act(const devices::StopBelt& stop);
  void act(const devices::SetGripper& set);
  void act(const devices::StopRobot& stop);
  void act(const devices::Push& push);
  void act(const devices::Place& place);
  void act(const devices::Remove& remove);
  [[nodiscard]] bool is_lost(int body) const;

  Parts parts_;
};

}  // namespace aprsim::world
