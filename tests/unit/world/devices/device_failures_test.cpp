// A device that fails ends, and the cell goes on as if it were not there.

#include <ostream>

#include <gtest/gtest.h>

#include "tests/unit/world/devices/device_scene.hpp"

namespace aprsim::test {
namespace {

struct Failure {
  const char* kind;
  const char* text;
};
std::ostream& operator<<(std::ostream& out, const Failure& failure) { return out << failure.kind; }

class DeviceFailures : public testing::TestWithParam<Failure> {};

TEST_P(DeviceFailures, AreFaultsOfTheDeviceAlone) {
  constexpr int kAt = 120;
  world::World world(scene_with(trouble(GetParam().kind, kAt) + mover("beside", "action: none")),
                     1);
  world::World without(scene_with(""), 1);
  for (world::World* cell : {&world, &without}) {
    cell->apply(0, api::ConveyorCommand{.run = true, .forward = true, .speed_m_s = 0.1});
  }
  advance(world, kAt);
  EXPECT_EQ(fault(snapshot_of(world), "trouble"), "");
  EXPECT_EQ(signal(snapshot_of(world), "trouble", "steps"), kAt);
  advance(world, 200);
  advance(without, kAt + 200);
  const api::Snapshot now = snapshot_of(world);
  EXPECT_EQ(fault(now, "trouble"), std::string("step 120: ") + GetParam().text);
  // Its state is that of its last good step.
  EXPECT_EQ(signal(now, "trouble", "steps"), kAt);
  EXPECT_EQ(world.physics().state_hash(), without.physics().state_hash());
  // The device after it goes on.
  const double noise = signal(now, "beside", "noise");
  world.step();
  EXPECT_NE(signal(snapshot_of(world), "beside", "noise"), noise);
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, DeviceFailures,
    testing::Values(Failure{"throw", "broken \\x1b[31m\\xff wire"},
                    Failure{"throw_other", "an exception that is no std::exception"},
                    Failure{"nan", "a number of its state is not finite or beyond 1e30"},
                    Failure{"index", "number 1000 of a state with 1"},
                    Failure{"no_body", "body 1000 of a cell with 1"},
                    Failure{"infinite_force",
                            "a force is inf, expected a number of at most 1000000.000000"},
                    Failure{"bad_pose", "a pose's quaternion has the length 2.000000, expected 1"},
                    Failure{"many", "more than 256 commands in one step"},
                    Failure{"push_then_throw", "too late"}),
    [](const auto& test) { return std::string(test.param.kind); });

}  // namespace
}  // namespace aprsim::test
