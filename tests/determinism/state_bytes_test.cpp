// A saved state as bytes, read into a world of the same scene elsewhere, goes on bit for bit.

#include "world/cell/state_bytes.hpp"

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/parameter_names.hpp"
#include "world/cell/world.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::world {
namespace {

class StateBytes : public testing::TestWithParam<scene::Simplification> {};
INSTANTIATE_TEST_SUITE_P(Modes, StateBytes,
                         testing::Values(scene::Simplification::kOff,
                                         scene::Simplification::kVirtualJoints,
                                         scene::Simplification::kMerge,
                                         scene::Simplification::kDormant));

std::shared_ptr<const scene::Scene> aprs_in(scene::Simplification mode) {
  auto scene = scene::load_scene("aprs", scene::default_data_paths());
  if (!scene) throw std::runtime_error(scene.error().message);
  scene->physics.simplification = mode;
  return std::make_shared<const scene::Scene>(std::move(*scene));
}

/// Motions of every kind, a guard, faults that wait and last, the belt, an intruder.
void go_on(World& world, std::uint64_t until, std::vector<std::uint64_t>& hashes) {
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
      const auto waits = world.apply(
          ticket, api::FaultCommand(api::InjectFault{.kind = "protective-stop",
                                                     .target = "motoman",
                                                     .parameters = {},
                                                     .trigger = api::WhenReported{"now"},
                                                     .duration = {}}));
      if (!waits) throw std::runtime_error(waits.error().message);
    }
    if (step == 350)
      world.apply(ticket, api::SetIntruder{api::Intruder{
                              {{0, 0, 3}, Eigen::Quaterniond::Identity()}, {0.1, 0.1, 0.1}}});
    if (step == 390) {
      api::Snapshot now;
      world.write(now);
      Pose up = now.robots[0].X_RT;
      up.p.z() += 0.05;
      world.apply(ticket,
                  api::RobotCommand{0,
                                    api::MoveTo{up, true, {}, {}},
                                    {api::Guard{.signal = {api::SignalKind::kForceR, 2, false},
                                                .value = 1e6,
                                                .label = "high"}}});
    }
    if (step == 700) world.apply(ticket, api::RobotCommand{1, api::SetGripper{0}});
    if (step == 800) {
      const auto told = world.apply(ticket, api::FaultCommand(api::ReportEvent{"now"}));
      if (!told) throw std::runtime_error(told.error().message);
    }
    if (step == 900) world.apply(ticket, api::ConveyorCommand{.forward = false});
    world.step();
    if (step % 50 == 49) hashes.push_back(world.state_hash());
  }
}

/// Saved while a straight move is being planned, and once more while it runs.
TEST_P(StateBytes, GoOnBitForBitElsewhere) {
  constexpr std::uint64_t kEnd = 1200;
  const auto scene = aprs_in(GetParam());
  for (const std::uint64_t middle : {std::uint64_t{395}, std::uint64_t{450}}) {
    std::vector<std::uint64_t> before, whole, elsewhere;
    World world(scene, 1);
    go_on(world, middle, before);
    const std::string bytes = to_bytes(world.save());
    go_on(world, kEnd, whole);
    ASSERT_NE(whole.front(), whole.back());

    World other(scene, 2);
    const auto state = from_bytes(bytes, other.save());
    ASSERT_TRUE(state) << state.error().message;
    EXPECT_EQ(to_bytes(*state), bytes);
    other.restore(*state);
    EXPECT_EQ(other.step_count(), middle);
    EXPECT_EQ(other.description()->seed, 1U);
    go_on(other, kEnd, elsewhere);
    EXPECT_EQ(elsewhere, whole) << "saved at step " << middle;
    EXPECT_EQ(to_bytes(other.save()), to_bytes(world.save()));
  }
}

TEST(DamagedState, IsRefused) {
  World world(aprs_in(scene::Simplification::kDormant), 1);
  const WorldState state = world.save();
  const std::string bytes = to_bytes(state);
  EXPECT_TRUE(from_bytes(bytes, state));
  for (const std::size_t kept :
       {std::size_t{0}, std::size_t{1}, bytes.size() / 2, bytes.size() - 1}) {
    const auto cut = from_bytes(bytes.substr(0, kept), state);
    ASSERT_FALSE(cut) << kept;
    EXPECT_EQ(cut.error().field, "state");
  }
  EXPECT_FALSE(from_bytes(bytes + '\0', state));
}

}  // namespace
}  // namespace aprsim::world
