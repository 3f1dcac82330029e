#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "world/cell/world.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::test {

inline std::shared_ptr<const scene::Scene> load_scene(const std::string& name) {
  auto scene = scene::load_scene(name, scene::default_data_paths());
  if (!scene) throw std::runtime_error(scene.error().message);
  return std::make_shared<const scene::Scene>(std::move(*scene));
}

/// Drives a World in stepped time as a controller would: one robot action after the other.
class CellScript {
 public:
  explicit CellScript(std::shared_ptr<const scene::Scene> scene) : world(std::move(scene), 1) {
    world.write(now);
  }

  /// Runs one action to its end; throws with the robot's own words when it ends in an error.
  void act(int robot, api::RobotAction action, double limit_s = 30,
           std::vector<api::Guard> guards = {}) {
    const api::Ticket ticket = ++ticket_;
    world.apply(ticket, api::RobotCommand{robot, std::move(action), std::move(guards)});
    const auto& status = now.robots[static_cast<std::size_t>(robot)].action;
    for (int step = 0; step < static_cast<int>(limit_s * 1e3); ++step) {
      advance();
      if (status.ticket != ticket || status.state == api::ActionState::kWorking) continue;
      if (status.state == api::ActionState::kError) throw std::runtime_error(status.description);
      return;
    }
    throw std::runtime_error("the action did not end in time");
  }

  void advance(int steps = 1) {
    for (; steps > 0; --steps) {
      world.step();
      world.write(now);
      if (each_step) each_step();
    }
  }

  [[nodiscard]] std::size_t body(const std::string& name) const {
    const auto& bodies = world.description()->bodies;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (bodies[i].name == name) return i;
    }
    throw std::runtime_error("no body " + name);
  }
  [[nodiscard]] Eigen::Isometry3d X_WB(const std::string& name) const {
    return now.bodies[body(name)].X_WB.isometry();
  }
  [[nodiscard]] Eigen::Isometry3d X_WS(const std::string& tray, const std::string& slot) const {
    for (const auto& entry : world.description()->bodies[body(tray)].slots) {
      if (entry.name == slot) return X_WB(tray) * entry.X_PS.isometry();
    }
    throw std::runtime_error("no slot " + slot + " in " + tray);
  }

  world::World world;
  api::Snapshot now;
  std::function<void()> each_step;  ///< called after every step, `now` being current

 private:
  api::Ticket ticket_ = 0;
};

}  // namespace aprsim::test
