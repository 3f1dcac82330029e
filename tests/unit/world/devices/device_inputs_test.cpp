// Inputs of devices: their effect, their ranges, saved states.

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/world/devices/device_scene.hpp"
#include "world/cell/commands/command_check.hpp"

namespace aprsim::test {
namespace {

constexpr double kPushed_kg = 0.2, kEarth_m_s2 = 9.81, kOnBelt = 0.8;
const std::string kOneTray =
    "trays:\n  - {name: small_gear_vessel_1, type: sku_small_gear_vessel, on: conveyor, "
    "xy_m: [0, 0]}\n";

api::SetSignals set(const std::string& device, const std::string& signal, double value) {
  return {{{device, signal, value}}};
}

/// The errors of a command before it is submitted and where it takes effect, which are the same.
std::string refusal(world::World& world, const api::SetSignals& command) {
  api::Command submitted{0, command};
  const auto checked = world::check(submitted, snapshot_of(world).cell);
  const auto applied = world.apply(0, command);
  EXPECT_EQ(checked.has_value(), applied.has_value());
  if (checked || applied) return "";
  EXPECT_EQ(checked.error().message, applied.error().message);
  return checked.error().field + ": " + applied.error().message;
}

TEST(DeviceInputs, ASetForceOvercomesFrictionAsCoulombSays) {
  std::mt19937 random(48);
  std::uniform_real_distribution<double> force(0, 4);
  for (int i = 0; i < 8; ++i) {
    const double force_n = force(random);
    world::World world(scene_with(pusher() + kOneTray), 1);
    advance(world, 200);
    ASSERT_TRUE(world.apply(0, set("pusher", "force_n", force_n)));
    advance(world, 100);
    const double held_n = kOnBelt * kPushed_kg * kEarth_m_s2;
    const double expected = force_n < held_n ? 0 : 0.1 * (force_n - held_n) / kPushed_kg;
    const api::Snapshot now = snapshot_of(world);
    EXPECT_NEAR(now.bodies[0].v_W.x(), expected, 0.01 * expected + 1e-6) << force_n;
    EXPECT_EQ(signal(now, "pusher", "force_n"), force_n);
    EXPECT_EQ(signal(now, "pusher", "pushed"), force_n > 0 ? 1 : 0);
  }
}

TEST(DeviceInputs, AreDescribedWithRangeAndUnit) {
  const world::World world(scene_with(scale() + pusher()), 1);
  const auto& devices = snapshot_of(world).cell->devices;
  EXPECT_TRUE(devices[0].inputs.empty());
  ASSERT_EQ(devices[1].inputs.size(), 1U);
  EXPECT_EQ(devices[1].signals, (std::vector<std::string>{"force_n", "pushed"}));
  const api::InputDescription& force = devices[1].inputs[0];
  EXPECT_EQ(force.signal, "force_n");
  EXPECT_EQ(force.min, 0);
  EXPECT_EQ(force.max, 10);
  EXPECT_EQ(force.unit, "N");
}

TEST(DeviceInputs, RefusalsNameDeviceSignalValueAndRange) {
  world::World world(scene_with(scale() + pusher()), 1);
  const std::uint64_t before = world.state_hash();
  EXPECT_EQ(refusal(world, set("pump", "on", 1)),
            "device: no device is named 'pump'; there are: scale, pusher");
  EXPECT_EQ(refusal(world, set("pusher", "speed", 1)),
            "signal: pusher has no input 'speed'; there are: force_n");
  EXPECT_EQ(refusal(world, set("scale", "mass_kg", 1)),
            "signal: signal 'mass_kg' of scale is set by the device only; of inputs there is none");
  EXPECT_EQ(refusal(world, set("pusher", "force_n", 10.5)),
            "value: force_n of pusher is 10.5 N, must be within 0 to 10 N");
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal(world, set("pusher", "force_n", kNan)),
            "value: force_n of pusher is nan N, must be within 0 to 10 N");
  EXPECT_EQ(refusal(world, {}), "settings: 0 settings, must be 1 to 2048");
  // One wrong setting, and none is made.
  api::SetSignals two = set("pusher", "force_n", 1);
  two.settings.push_back({"pusher", "force_n", -1});
  EXPECT_NE(refusal(world, two), "");
  EXPECT_EQ(world.state_hash(), before);
}

TEST(DeviceInputs, AreInHashesAndSavedStates) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> force(0, 10);
  world::World world(scene_with(pusher("a") + pusher("b") + kOneTray), 1), other(world.scene(), 1);
  for (int i = 0; i < 20; ++i) {
    const double force_n = force(random);
    const std::uint64_t before = world.state_hash();
    ASSERT_TRUE(world.apply(0, set(i % 2 == 0 ? "a" : "b", "force_n", force_n)));
    EXPECT_NE(world.state_hash(), before) << i;
    other.restore(world.save());
    EXPECT_EQ(other.state_hash(), world.state_hash()) << i;
    EXPECT_EQ(signal(snapshot_of(other), i % 2 == 0 ? "a" : "b", "force_n"), force_n) << i;
    advance(world, 10);
    advance(other, 10);
    EXPECT_EQ(other.state_hash(), world.state_hash()) << i;
  }
}

}  // namespace
}  // namespace aprsim::test
