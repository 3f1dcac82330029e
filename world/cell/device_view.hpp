#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "world/base/time.hpp"
#include "world/cell/cell_settings.hpp"
#include "world/cell/machines/conveyor_drive.hpp"
#include "world/cell/machines/simulated_robot.hpp"
#include "world/devices/interface/device.hpp"
#include "world/physics/physics_world.hpp"
#include "world/sensors/photo_eyes.hpp"

namespace aprsim::world {

/// The cell as devices see it. Thread: the world's.
class DeviceView {
 public:
  struct Parts {
    const CellSettings& settings;
    const std::vector<std::string>& robot_names;
    std::span<const SimulatedRobot> robots;
    const physics::PhysicsWorld& physics;
    const ConveyorDrive* conveyor = nullptr;         ///< null = the cell has none
    const sensors::PhotoEyes* photo_eyes = nullptr;  ///< the same
    std::uint64_t step = 0;
    SimTime time{};
  };
  /// The cell at this moment; valid until the next call and while the parts' names live.
  [[nodiscard]] const device::Cell& of(const Parts& parts);

 private:
  void read_bodies(const Parts& parts);
  void read_robots(const Parts& parts);
  void read_belt(const Parts& parts);

  std::vector<device::Body> bodies_;
  std::vector<device::Robot> robots_;
  std::vector<std::vector<double>> joints_;  ///< of each robot
  std::vector<device::PhotoEye> photo_eyes_;
  device::Belt belt_;
  device::Cell cell_;
};

}  // namespace aprsim::world
