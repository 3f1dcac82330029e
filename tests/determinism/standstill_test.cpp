// Steps of a cell that is at rest advance its clocks and cameras alone. They must leave the bits
// that complete steps leave, whatever acted on the cell before.

#include <algorithm>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/parameter_names.hpp"
#include "world/cell/state_bytes.hpp"
#include "world/cell/world.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::world {
namespace {

constexpr std::uint64_t kBlock = 40;  ///< steps, fewer than a proof takes

std::shared_ptr<const scene::Scene> shipped(const std::string& name) {
  return std::make_shared<const scene::Scene>(
      scene::load_scene(name, scene::default_data_paths()).value());
}

/// A world that may skip steps beside one that never does: its state is restored all the time.
class Pair {
 public:
  explicit Pair(const std::shared_ptr<const scene::Scene>& scene)
      : skips_(scene, 1), steps_(scene, 1) {}

  void advance(std::uint64_t steps) {
    for (std::uint64_t left = steps; left > 0;) {
      const std::uint64_t block = std::min(left, kBlock);
      steps_.restore(steps_.save());
      for (std::uint64_t i = 0; i < block; ++i) steps_.step();
      EXPECT_FALSE(steps_.stands_still());
      // As an embedded cell does: single steps, or all of a cell that is at rest.
      for (std::uint64_t i = 0; i < block; ++i) {
        if (skips_.stands_still()) {
          skips_.step_still(block - i);
          skipped += block - i;
          break;
        }
        skips_.step();
      }
      left -= block;
    }
  }
  void apply(const api::Command& command) {
    const auto ticket = ++ticket_;
    EXPECT_EQ(skips_.apply_any(ticket, command).has_value(),
              steps_.apply_any(ticket, command).has_value());
  }
  void expect_equal() const {
    ASSERT_EQ(to_bytes(skips_.save()), to_bytes(steps_.save())) << "step " << steps_.step_count();
    api::Snapshot a, b;
    skips_.write(a);
    steps_.write(b);
    ASSERT_EQ(a.contacts.size(), b.contacts.size());
    ASSERT_EQ(a.contact_count, b.contact_count);
    ASSERT_EQ(a.time, b.time);
    for (std::size_t r = 0; r < a.robots.size(); ++r) {
      ASSERT_EQ(a.robots[r].force_T_R, b.robots[r].force_T_R);
      ASSERT_EQ(a.robots[r].vision.number, b.robots[r].vision.number);
      ASSERT_EQ(a.robots[r].vision.detections.size(), b.robots[r].vision.detections.size());
    }
  }
  [[nodiscard]] const World& world() const { return skips_; }

  std::uint64_t skipped = 0;  ///< steps

 private:
  World skips_, steps_;
  api::Ticket ticket_ = 0;
};

/// Commands of all kinds at random.
class RandomCommands {
 public:
  explicit RandomCommands(const World& world) : world_(world) {}

  api::Command next() {
    const int robots = static_cast<int>(world_.robots().size());
    const int robot = integer(0, std::max(robots - 1, 0));
    switch (integer(robots > 0 ? 0 : 4, 7)) {
      case 0:
        return of(robot, api::InitRobot{});
      case 1: {
        const auto& q = world_.robots()[static_cast<std::size_t>(robot)].q();
        const int joint = integer(0, static_cast<int>(q.size()) - 1);
        return of(robot,
                  api::MoveJoints{{{.joint = joint, .position_rad = q(joint) + real(-0.1, 0.1)}}});
      }
      case 2:
        return of(robot, api::SetGripper{real(0, 1) < 0.5 ? 0.0 : 1.0});
      case 3:
        return of(robot, api::Dwell{std::chrono::milliseconds(integer(10, 500))});
      case 4:
        return {0, api::ConveyorCommand{.run = real(0, 1) < 0.7,
                                        .forward = real(0, 1) < 0.5,
                                        .speed_m_s = real(0, 1) < 0.5 ? 0 : 0.1,
                                        .watchdog_s = real(0, 1) < 0.5 ? 0 : real(0.2, 2)}};
      case 5:
        return {0, api::ConveyorCommand{.run = false, .fault_reset = true}};
      case 6:
        return {0, api::SetIntruder{
                       api::Intruder{{{real(-1, 1), real(-1, 1), 0.5}, {}}, {0.2, 0.2, 1}}}};
      default:
        return {0, api::SetIntruder{}};
    }
  }
  std::uint64_t rest() { return static_cast<std::uint64_t>(integer(1, 1500)); }

 private:
  template <typename Action>
  static api::Command of(int robot, Action action) {
    return {0, api::RobotCommand{robot, std::move(action)}};
  }
  int integer(int low, int high) { return std::uniform_int_distribution(low, high)(random_); }
  double real(double low, double high) {
    return std::uniform_real_distribution(low, high)(random_);
  }

  const World& world_;
  std::mt19937 random_{7};
};

class StandstillOf : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Scenes, StandstillOf,
                         testing::Values("aprs", "aprs_2025", "aprs_lab", "empty_belt",
                                         "taskboard"),
                         [](const auto& tested) { return tested.param; });

TEST_P(StandstillOf, KeepsTheBitsOfCompleteSteps) {
  Pair pair(shipped(GetParam()));
  RandomCommands commands(pair.world());
  pair.advance(2000);
  pair.expect_equal();
  for (int round = 0; round < 15 && !HasFatalFailure(); ++round) {
    for (int i = 0; i < 3; ++i) {
      pair.apply(commands.next());
      pair.advance(commands.rest() / 4);
    }
    pair.advance(commands.rest());
    pair.expect_equal();
  }
  // It is at rest for a good part of that time.
  EXPECT_GT(pair.skipped, 2000U);
}

TEST(Standstill, EndsWithEveryCommand) {
  World world(shipped("aprs"), 1);
  const auto settle = [&] {
    for (int i = 0; i < 5000 && !world.stands_still(); ++i) world.step();
    ASSERT_TRUE(world.stands_still());
  };
  settle();
  const std::vector<api::Command> commands{{0, api::RobotCommand{0, api::InitRobot{}}},
                                           {0, api::ConveyorCommand{.run = true, .speed_m_s = 0.1}},
                                           {0, api::ConveyorCommand{.run = false}},
                                           {0, api::SetIntruder{}},
                                           {0, api::FaultCommand{api::ReportEvent{"a"}}}};
  for (const api::Command& command : commands) {
    ASSERT_TRUE(world.apply_any(1, command));
    EXPECT_FALSE(world.stands_still());
    if (!std::holds_alternative<api::ConveyorCommand>(command.body)) settle();
  }
  settle();
  world.restore(world.save());
  EXPECT_FALSE(world.stands_still());
}

TEST(Standstill, WaitsForADriveWhoseWatchdogRuns) {
  World world(shipped("aprs"), 1);
  world.apply(1, api::ConveyorCommand{.run = true, .speed_m_s = 0, .watchdog_s = 3});
  for (int i = 0; i < 2900; ++i) world.step();
  EXPECT_FALSE(world.stands_still());
  ASSERT_TRUE(world.conveyor()->state().run);
  for (int i = 0; i < 2000; ++i) world.step();
  EXPECT_EQ(world.conveyor()->state().fault, api::DriveFault::kWatchdog);
  EXPECT_TRUE(world.stands_still());
}

TEST(Standstill, NeverHoldsOnAMovingBelt) {
  World world(shipped("empty_belt"), 1);
  world.apply(1, api::ConveyorCommand{.run = true, .speed_m_s = 0.1});
  for (int i = 0; i < 4000; ++i) {
    world.step();
    ASSERT_FALSE(world.stands_still());
  }
}

}  // namespace
}  // namespace aprsim::world
