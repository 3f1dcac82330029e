#include "world/cell/cell_settings.hpp"

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"
#include "world/scene/model/tool.hpp"

namespace aprsim::test {
namespace {

using api::CurtainReaction;
using namespace std::chrono_literals;

world::CellSettings settings_of(const scene::Scene& scene) {
  return world::settings_of(scene, *world::load_models(scene));
}

TEST(CellSettings, AreThoseOfTheScene) {
  const auto scene = load_scene("aprs");
  const world::CellSettings settings = settings_of(*scene);
  EXPECT_EQ(settings.step_s, scene->physics.step_s);
  EXPECT_EQ(settings.step_size, 1ms);
  EXPECT_EQ(settings.bodies.size(), scene->trays.size() + scene->gears.size());
  EXPECT_EQ(settings.tool_count, scene::tools_of(*scene).size());
  ASSERT_EQ(settings.joint_names.size(), 2U);
  EXPECT_EQ(settings.joint_names[0].size(), 6U);
  EXPECT_EQ(settings.joint_names[1].size(), 7U);
  EXPECT_EQ(settings.conveyor.has_value(), scene->conveyor.has_value());
  EXPECT_EQ(settings.light_curtain.has_value(), scene->light_curtain.has_value());
}

TEST(CellSettings, NumberBodiesAsTheDescriptionDoes) {
  const world::World world(load_scene("aprs"), 1);
  const auto& described = world.description()->bodies;
  ASSERT_EQ(world.settings().bodies.size(), described.size());
  for (std::size_t i = 0; i < described.size(); ++i) {
    EXPECT_EQ(world.settings().find_body(described[i].name), static_cast<int>(i));
    EXPECT_EQ(world.settings().bodies[i].type, described[i].type);
  }
  EXPECT_EQ(world.settings().find_body("nothing"), std::nullopt);
}

TEST(CellSettings, TellWhatTheLightCurtainStops) {
  auto scene = *load_scene("aprs");
  const auto stops = [&](CurtainReaction reaction) {
    scene.light_curtain->reaction = reaction;
    const world::CellSettings settings = settings_of(scene);
    return std::pair(settings.curtain_stops_belt(), settings.curtain_stops_robots());
  };
  EXPECT_EQ(stops(CurtainReaction::kNone), std::pair(false, false));
  EXPECT_EQ(stops(CurtainReaction::kBeltStop), std::pair(true, false));
  EXPECT_EQ(stops(CurtainReaction::kProtectiveStop), std::pair(false, true));
  EXPECT_EQ(stops(CurtainReaction::kAll), std::pair(true, true));
  scene.light_curtain.reset();
  EXPECT_FALSE(settings_of(scene).curtain_stops_belt());
  EXPECT_FALSE(settings_of(scene).curtain_stops_robots());
}

}  // namespace
}  // namespace aprsim::test
