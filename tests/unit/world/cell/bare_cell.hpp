#pragma once

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/cell_script.hpp"
#include "world/cell/cell_readings.hpp"
#include "world/cell/fault_executor.hpp"

namespace aprsim::test {

/// The parts of the default cell at its start, without a World that runs them.
class BareCell {
 public:
  BareCell()
      : settings(world::settings_of(*scene_, *models_)),
        conveyor({.max_speed_m_s = 1, .accel_m_s2 = 1, .decel_m_s2 = 1, .emergency_decel_m_s2 = 1}),
        photo_eyes(*settings.conveyor),
        vision(*scene_, settings.step_size, 1, settings.bodies.size()) {
    std::vector<std::vector<Eigen::Isometry3d>> X_WL;
    robots.reserve(models_->size());
    for (std::size_t i = 0; i < models_->size(); ++i) {
      robots.emplace_back(*scene_, i, (*models_)[i]);
      const auto links = robots.back().X_WL();
      X_WL.emplace_back(links.begin(), links.end());
    }
    physics.emplace(*scene_, *models_, X_WL);
  }

  [[nodiscard]] world::FaultExecutor executor() {
    return world::FaultExecutor({settings, robots, *physics, &conveyor, &photo_eyes, vision});
  }
  [[nodiscard]] world::CellReadings readings() const {
    return {settings, robots, *physics, &conveyor, &photo_eyes};
  }
  [[nodiscard]] int body(const std::string& name) const {
    const auto index = settings.find_body(name);
    if (!index) throw std::runtime_error("no body " + name);
    return *index;
  }
  [[nodiscard]] Eigen::Isometry3d X_WB(int body) const {
    const physics::BodyState state = physics->body(body);
    return Pose{state.p_WB, state.q_WB}.isometry();
  }

 private:
  std::shared_ptr<const scene::Scene> scene_ = load_scene("aprs");
  world::ArmModels models_ = world::load_models(*scene_);

 public:
  world::CellSettings settings;
  std::vector<world::SimulatedRobot> robots;
  std::optional<physics::PhysicsWorld> physics;
  world::ConveyorDrive conveyor;
  sensors::PhotoEyes photo_eyes;
  sensors::CellVision vision;
};

}  // namespace aprsim::test
