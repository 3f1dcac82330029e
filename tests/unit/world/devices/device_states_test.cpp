// The state of devices: deterministic, hashed, saved, restored, and checked where it is read.

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/world/devices/device_scene.hpp"
#include "world/cell/scene_editor.hpp"
#include "world/cell/state_bytes.hpp"

namespace aprsim::test {
namespace {

std::string busy_devices() {
  return scale(", full_kg: 0.15, settling_s: 0.02") +
         mover("push", "action: push, body: small_gear_vessel_1, amount: 2, until_step: 700") +
         mover("run", "action: run_belt, amount: 0.2, at_step: 300, once: true") +
         trouble("throw", 450);
}

TEST(DeviceStates, TheSameSceneGivesTheSameHashes) {
  const auto scene = scene_with(busy_devices());
  world::World first(scene, 1), second(scene, 1);
  for (int i = 0; i < 40; ++i) {
    advance(first, 25);
    advance(second, 25);
    ASSERT_EQ(first.state_hash(), second.state_hash()) << i;
  }
}

TEST(DeviceStates, MemoryAndFaultsArePartOfTheHash) {
  // Nothing but the noise of the devices differs between these steps of a cell at rest.
  world::World world(scene_with(mover("quiet", "action: none")), 1);
  advance(world, 2000);
  const std::uint64_t bodies = world.physics().state_hash(), before = world.state_hash();
  world.step();
  EXPECT_EQ(world.physics().state_hash(), bodies);
  EXPECT_NE(world.state_hash(), before);
  EXPECT_FALSE(world.stands_still());
}

TEST(DeviceStates, ASavedStateContinuesBitForBit) {
  const auto scene = scene_with(busy_devices());
  std::mt19937 random(3);
  for (int round = 0; round < 6; ++round) {
    world::World original(scene, 1);
    advance(original, static_cast<int>(random() % 900));
    const std::string bytes = world::to_bytes(original.save());
    world::World restored(scene, 9);
    const auto state = world::from_bytes(bytes, restored.save());
    ASSERT_TRUE(state) << state.error().message;
    restored.restore(*state);
    EXPECT_EQ(restored.state_hash(), original.state_hash()) << round;
    advance(original, 300);
    advance(restored, 300);
    EXPECT_EQ(restored.state_hash(), original.state_hash()) << round;
    EXPECT_EQ(fault(snapshot_of(restored), "trouble"), fault(snapshot_of(original), "trouble"));
  }
}

TEST(DeviceStates, StatesThatNoDeviceCanHaveAreRefused) {
  const world::World world(scene_with(mover("quiet", "action: none")), 1);
  const world::WorldState like = world.save();
  const auto refusal = [&like](const world::WorldState& state) {
    const auto read = world::from_bytes(world::to_bytes(state), like);
    return read ? std::string() : read.error().message;
  };
  EXPECT_EQ(refusal(like), "");
  world::WorldState state = like;
  state.devices[0].numbers.push_back(0);
  EXPECT_NE(refusal(state).find("of another size"), std::string::npos) << refusal(state);
  state = like;
  state.devices[0].numbers[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal(state), "");
  state = like;
  state.devices[0].fault = std::string(10'000, 'x');
  EXPECT_NE(refusal(state).find("too long"), std::string::npos) << refusal(state);
  state = like;
  state.devices.clear();
  EXPECT_NE(refusal(state), "");
}

TEST(DeviceStates, ASpawnedBodyLeavesThemAsTheyAre) {
  auto world = std::make_unique<world::World>(scene_with(scale()), 1);
  advance(*world, 100);
  const auto before = world->save().devices[0].numbers;
  const Pose at{.p = {0, 0, 1.0}};
  ASSERT_TRUE(world::SceneEditor(world).apply(api::SpawnBody{"sku_part_large_gear", "spare", at}));
  EXPECT_EQ(world->save().devices[0].numbers, before);
  advance(*world, 1500);
  EXPECT_NEAR(signal(snapshot_of(*world), "scale", "mass_kg"), 0.033, 1e-4);
}

TEST(DeviceStates, AParameterChangesInTheRunningCell) {
  auto world = std::make_unique<world::World>(scene_with(scale(", full_kg: 5")), 1);
  const auto set = [&world](const std::string& parameter, const std::string& value) {
    const auto done = world::SceneEditor(world).apply(
        api::SetSceneValue{"devices.scale.parameters." + parameter, value});
    return done ? std::string() : done.error().message;
  };
  advance(*world, 100);
  EXPECT_EQ(set("full_kg", "0"), "");
  advance(*world, 2);
  EXPECT_EQ(signal(snapshot_of(*world), "scale", "full"), 1);
  const std::uint64_t hash = world->state_hash();
  EXPECT_NE(set("settling_s", "-1").find("found -1, expected a number in [0.001, 60]"),
            std::string::npos)
      << set("settling_s", "-1");
  EXPECT_EQ(world->state_hash(), hash);
}

}  // namespace
}  // namespace aprsim::test
