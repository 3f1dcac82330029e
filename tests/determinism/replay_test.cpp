// The same scene, seed and commands at the same steps give the same bits.

#include <memory>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "world/cell/world.hpp"
#include "world/robot/planning/plan_job.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::world {
namespace {

std::shared_ptr<const scene::Scene> load(const std::string& name) {
  auto scene = scene::load_scene(name, scene::default_data_paths());
  if (!scene) throw std::runtime_error(scene.error().message);
  return std::make_shared<const scene::Scene>(std::move(*scene));
}

api::MoveJoints turn(double rad, int step) {
  return {{{.joint = step % 6, .position_rad = step % 260 == 0 ? rad : -rad}}};
}

/// Runs the belt, both arms and both grippers for two simulated seconds.
std::vector<std::uint64_t> run(const std::shared_ptr<const scene::Scene>& scene,
                               std::span<robot::PlanPrefetcher* const> prefetchers = {}) {
  World world(scene, 1, prefetchers);
  api::Ticket ticket = 0;
  for (int robot = 0; robot < 2; ++robot) {
    world.apply(++ticket, api::RobotCommand{robot, api::InitRobot{}});
    world.apply(++ticket,
                api::RobotCommand{robot, api::MoveJoints{{{.joint = 0, .position_rad = 0.3},
                                                          {.joint = 4, .position_rad = -1.2}}}});
  }
  world.apply(++ticket, api::ConveyorCommand{.run = true, .forward = true, .speed_m_s = 0.1});
  std::vector<std::uint64_t> hashes;
  for (int step = 0; step < 2000; ++step) {
    if (step == 700) world.apply(++ticket, api::RobotCommand{0, api::StopMotion{}});
    if (step == 1000) world.apply(++ticket, api::RobotCommand{1, api::SetGripper{0}});
    if (step % 130 == 0 && step > 1000) {  // also while the one before is being planned
      world.apply(++ticket, api::RobotCommand{0, turn(0.1, step)});
      world.apply(++ticket, api::RobotCommand{0, turn(0.2, step)});
    }
    if (step == 1200) world.apply(++ticket, api::ConveyorCommand{.forward = false});
    world.step();
    if (step % 100 == 99) hashes.push_back(world.state_hash());
  }
  return hashes;
}

TEST(Determinism, TheDefaultCellRepeatsBitForBit) {
  const auto scene = load("aprs");
  const auto first = run(scene);
  EXPECT_EQ(first, run(scene));
  EXPECT_NE(first.front(), first.back()) << "nothing moved, so nothing was compared";
}

/// Plans made ahead by threads, and by none.
TEST(Determinism, PlanningThreadsChangeNoBits) {
  const auto scene = load("aprs");
  robot::PlanningThread fanuc, motoman;
  const std::vector<robot::PlanPrefetcher*> threads{&fanuc, &motoman};
  EXPECT_EQ(run(scene), run(scene, threads));
}

}  // namespace
}  // namespace aprsim::world
