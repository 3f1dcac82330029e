// A saved state, put back into the same or another world of the scene, goes on bit for bit.

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/parameter_names.hpp"
#include "world/cell/world.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::world {
namespace {

class Checkpoint : public testing::TestWithParam<scene::Simplification> {};
INSTANTIATE_TEST_SUITE_P(Modes, Checkpoint,
                         testing::Values(scene::Simplification::kOff,
                                         scene::Simplification::kVirtualJoints,
                                         scene::Simplification::kMerge,
                                         scene::Simplification::kDormant));

std::shared_ptr<const scene::Scene> load(scene::Simplification mode) {
  auto scene = scene::load_scene("aprs", scene::default_data_paths());
  if (!scene) throw std::runtime_error(scene.error().message);
  scene->physics.simplification = mode;
  return std::make_shared<const scene::Scene>(std::move(*scene));
}

/// Arms, grippers and the belt in motion, with commands at fixed steps.
void advance(World& world, std::uint64_t until, std::vector<std::uint64_t>& hashes) {
  while (world.step_count() < until) {
    const std::uint64_t step = world.step_count();
    const api::Ticket ticket = step + 1;
    if (step == 0) {
      for (int robot = 0; robot < 2; ++robot) {
        world.apply(ticket, api::RobotCommand{robot, api::InitRobot{}});
        world.apply(ticket, api::RobotCommand{
                                robot, api::MoveJoints{{{.joint = 0, .position_rad = 0.3},
                                                        {.joint = 4, .position_rad = -1.2}}}});
      }
      world.apply(ticket, api::ConveyorCommand{.run = true, .forward = true, .speed_m_s = 0.1});
    }
    if (step == 500) world.apply(ticket, api::RobotCommand{0, api::StopMotion{}});
    if (step == 700) world.apply(ticket, api::RobotCommand{1, api::SetGripper{0}});
    if (step == 900) world.apply(ticket, api::ConveyorCommand{.forward = false});
    world.step();
    if (step % 50 == 49) hashes.push_back(world.state_hash());
  }
}

TEST_P(Checkpoint, GoesOnBitForBit) {
  constexpr std::uint64_t kMiddle = 400, kEnd = 1200;
  const auto scene = load(GetParam());
  std::vector<std::uint64_t> before, whole, again, elsewhere;
  World world(scene, 1);
  advance(world, kMiddle, before);
  const WorldState saved = world.save();
  advance(world, kEnd, whole);
  ASSERT_NE(whole.front(), whole.back());

  world.restore(saved);
  EXPECT_EQ(world.step_count(), kMiddle);
  EXPECT_EQ(world.state_hash(), before.back());
  advance(world, kEnd, again);
  EXPECT_EQ(again, whole);

  World other(scene, 2);
  other.restore(saved);
  EXPECT_EQ(other.description()->seed, 1U);
  advance(other, kEnd, elsewhere);
  EXPECT_EQ(elsewhere, whole);

  api::Snapshot one, two;
  world.write(one);
  other.write(two);
  for (std::size_t i = 0; i < one.robots.size(); ++i) {
    EXPECT_EQ(one.robots[i].vision.number, two.robots[i].vision.number);
    EXPECT_EQ(one.robots[i].action.ticket, two.robots[i].action.ticket);
    EXPECT_EQ(one.robots[i].moving, two.robots[i].moving);
  }
  EXPECT_EQ(one.conveyor.travel_m, two.conveyor.travel_m);
}

}  // namespace
}  // namespace aprsim::world
