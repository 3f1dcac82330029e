// A part that has fallen out of the cell: told in the snapshot, seen by nothing, back after a
// reset.

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"
#include "world/runtime/simulation.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;

/// The default cell without its floor, with a gear beside everything else.
std::shared_ptr<const scene::Scene> without_floor() {
  auto scene = *load_scene("aprs");
  scene.floor = false;
  scene.gears.push_back({"falling", scene.gears[0].type, Pose{.p = {3, 3, 1.5}}});
  return std::make_shared<const scene::Scene>(std::move(scene));
}

TEST(LostPart, IsToldAndNothingElseStops) {
  CellScript cell(without_floor());
  const std::size_t part = cell.body("falling");
  cell.act(0, api::InitRobot{});
  cell.advance(6000);
  ASSERT_TRUE(cell.now.bodies[part].lost_step);
  EXPECT_LT(*cell.now.bodies[part].lost_step, 2000u);
  EXPECT_EQ(std::count_if(cell.now.bodies.begin(), cell.now.bodies.end(),
                          [](const auto& body) { return body.lost_step.has_value(); }),
            1);
  cell.act(0, api::MoveJoints{{{.joint = 0, .position_rad = 0.4}}});
}

// Where it was lost, under a camera or over the belt, nothing sees or weighs it.
TEST(LostPart, IsOutOfSight) {
  auto scene = *load_scene("aprs");
  scene.floor = false;
  const auto& belt = *scene.conveyor;

  // Under the belt, where it cannot be put in a scene's file: a trapdoor.
  Pose under = belt.X_WC;
  under.p.z() -= 0.5;
  scene.fixed.clear();
  scene.gears.push_back({"falling", scene.gears[0].type, under});
  CellScript cell(std::make_shared<const scene::Scene>(std::move(scene)));
  const auto part = static_cast<int>(cell.body("falling"));
  cell.advance(3000);
  ASSERT_TRUE(cell.now.bodies[static_cast<std::size_t>(part)].lost_step);
  for (const auto& robot : cell.now.robots) {
    for (const auto& seen : robot.vision.detections) EXPECT_NE(seen.body, part);
  }
}

TEST(LostPart, AResetBringsItBackAndALoadKeepsItLost) {
  world::Simulation simulation(without_floor(), {.speed = std::nullopt});
  simulation.start();
  const auto wait_for = [&](const auto& condition) {
    const auto deadline = std::chrono::steady_clock::now() + 60s;
    auto snapshot = simulation.latest();
    while (!condition(*snapshot) && std::chrono::steady_clock::now() < deadline) {
      snapshot = simulation.wait_newer(snapshot, deadline);
    }
    EXPECT_TRUE(condition(*snapshot));
    return snapshot;
  };
  const auto command = [&](api::SimulationCommand body) {
    const auto ticket = simulation.submit({.body = std::move(body)});
    EXPECT_TRUE(ticket);
    return wait_for([&](const auto& now) { return now.applied >= *ticket; });
  };
  const auto lost = [](const api::Snapshot& now) {
    return now.bodies.back().lost_step.has_value();
  };
  const auto gone = wait_for(lost);
  EXPECT_TRUE(gone->world_fault.empty());
  command(api::Pause{});
  command(api::SaveState{"lost"});
  EXPECT_FALSE(lost(*command(api::Reset{})));
  EXPECT_TRUE(lost(*command(api::LoadState{"lost"})));
  EXPECT_EQ(simulation.latest()->world_stops, 0u);
}

}  // namespace
}  // namespace aprsim::test
