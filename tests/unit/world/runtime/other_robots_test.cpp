// Resets of a running simulation to scenes with other robots.

#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/eventually.hpp"
#include "world/runtime/simulation.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::test {
namespace {

std::shared_ptr<const scene::Scene> load_scene(const std::string& name) {
  auto scene = scene::load_scene(name, scene::default_data_paths());
  if (!scene) throw std::runtime_error(scene.error().message);
  return std::make_shared<const scene::Scene>(*std::move(scene));
}

class OtherRobots : public testing::Test {
 protected:
  OtherRobots() : simulation(load_scene("aprs"), {.paused = true}) { simulation.start(); }

  /// The snapshot after the command; `refused` has its error.
  api::SnapshotPtr command(decltype(api::Command::body) body) {
    const auto ticket = simulation.submit({.endpoint = 1, .body = std::move(body)});
    if (!ticket) {
      refused = ticket.error();
      return simulation.latest();
    }
    EXPECT_TRUE(eventually([&] { return simulation.latest()->applied >= *ticket; }));
    const auto now = simulation.latest();
    if (now->failures && now->failures->back().ticket == *ticket) {
      refused = now->failures->back().error;
    }
    return now;
  }

  world::Simulation simulation;
  Error refused;
};

TEST_F(OtherRobots, ResetsToAndFroBetweenOtherRobots) {
  const std::uint64_t begin = simulation.latest()->step;
  command(api::SimulationCommand(api::SaveState{"two"}));
  std::map<std::string, std::uint64_t> hashes;
  for (const std::string name : {"arms", "aprs", "motoman_only", "arms", "motoman_only", "aprs"}) {
    api::Reset reset;
    reset.scene_name = name;
    const auto there = command(api::SimulationCommand(reset));
    ASSERT_EQ(refused.message, "");
    EXPECT_EQ(there->cell->scene, name);
    EXPECT_EQ(there->robots.size(), load_scene(name)->robots.size());
    command(api::SimulationCommand(api::StepBy{30}));
    ASSERT_TRUE(eventually([&] { return simulation.latest()->step == 30; }));
    // The bits are those of a world that was built of this scene alone.
    world::World alone(load_scene(name), load_scene(name)->seed);
    for (int i = 0; i < 30; ++i) alone.step();
    api::Snapshot expected;
    alone.write(expected);
    const auto now = simulation.latest();
    ASSERT_EQ(now->robots.size(), expected.robots.size());
    for (std::size_t r = 0; r < expected.robots.size(); ++r) {
      EXPECT_EQ(now->robots[r].X_RT.p, expected.robots[r].X_RT.p) << name;
    }
    const auto [known, is_new] = hashes.try_emplace(name, alone.state_hash());
    EXPECT_EQ(known->second, alone.state_hash());
  }
  const auto back = command(api::SimulationCommand(api::LoadState{"two"}));
  EXPECT_EQ(refused.message, "");
  EXPECT_EQ(back->robots.size(), 2U);
  EXPECT_EQ(back->step, begin);
}

TEST_F(OtherRobots, CommandsToRobotsThatHaveLeftFail) {
  const auto before = simulation.latest()->cell;
  api::Reset reset;
  reset.scene_name = "arms";
  command(api::SimulationCommand(reset));
  ASSERT_EQ(refused.message, "");
  for (const int robot : {0, 1}) {
    const auto ticket = simulation.submit(
        {.endpoint = 3, .body = api::RobotCommand{robot, api::InitRobot{}}, .cell = before});
    ASSERT_TRUE(ticket);
    ASSERT_TRUE(eventually([&] { return simulation.latest()->applied >= *ticket; }));
    const auto now = simulation.latest();
    ASSERT_TRUE(now->failures);
    EXPECT_EQ(now->failures->back().ticket, *ticket);
    EXPECT_EQ(now->failures->back().error.message,
              "the robot " + before->robots[static_cast<std::size_t>(robot)].name +
                  " has left the cell, or its place in the scene");
    EXPECT_EQ(now->robots[static_cast<std::size_t>(robot)].action.ticket, 0U);
  }
}

TEST(OtherRobotsOfAnOwner, AreRefusedByTheOwnerBeforeAnythingChanges) {
  std::vector<std::string> asked;
  world::Simulation simulation(
      load_scene("aprs"),
      {.paused = true, .admits_scene = [&](const scene::Scene& next) -> Result<void> {
         asked.push_back(next.name);
         return fail(ErrorCode::kFailedPrecondition, "crcl.ur5e", "the port is in use");
       }});
  simulation.start();
  api::Reset reset;
  reset.scene_name = "arms";
  const auto refused = simulation.submit({.body = api::SimulationCommand(reset)});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, "the port is in use");
  EXPECT_EQ(asked, std::vector<std::string>{"arms"});
  EXPECT_EQ(simulation.latest()->epoch, 0U);
  // A reset of the present scene needs no ports.
  EXPECT_TRUE(simulation.submit({.body = api::SimulationCommand(api::Reset{})}));
}

}  // namespace
}  // namespace aprsim::test
