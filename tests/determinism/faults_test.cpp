// A cell with injected faults runs the same twice, and on from a saved state.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;

struct Injection {
  std::uint64_t step;
  api::InjectFault fault;
};

/// Faults of many kinds, started at a time, by triggers and by commands.
std::vector<Injection> injections() {
  const auto timed = [](const char* kind, const char* target, std::map<std::string, double> values,
                        SimTime at, std::optional<SimTime> duration) {
    return api::InjectFault{kind, target, std::move(values), api::AtTime{at}, duration};
  };
  using faults::Quantity;
  return {
      {0, timed("robot-slow", "fanuc", {{"share", 0.5}}, 300ms, 500ms)},
      {0, timed("joint-backlash", "motoman:2", {}, 200ms, 900ms)},
      {0, timed("encoder-bias", "fanuc:1", {}, 250ms, {})},
      {0, timed("gripper-leak", "fanuc", {{"over", 1}}, 100ms, {})},
      {0, timed("belt-slip", "", {}, 350ms, 300ms)},
      {0, timed("camera-flips-trays", "fanuc", {}, 0ms, {})},
      {0, timed("camera-late", "motoman", {{"delay", 0.3}}, 150ms, 600ms)},
      {0, timed("tray-shifted", "medium_gear_vessel_1", {{"y", 0.02}}, 450ms, {})},
      {0, timed("part-swapped", "part_large_gear_1:part_medium_gear_1", {}, 420ms, {})},
      {0, timed("tray-jammed", "kit_s2l2_vessel_1", {{"distance", 10}}, 500ms, 300ms)},
      {0, api::InjectFault{"curtain-broken", "", {}, api::WhenReported{"lunch"}, 200ms}},
      {0, api::InjectFault{"robot-breakdown",
                           "motoman",
                           {},
                           api::WhenCrossing{Quantity::kBeltTravel, "", 1, true, 0.03},
                           {}}},
      {0, timed("picture-dirt", "fanuc_table", {{"spots", 3}}, 200ms, 400ms)},
      {600, api::InjectFault{"part-missing", "part_large_gear_2", {}, {}, {}}},
  };
}

void go_on(world::World& world, std::uint64_t until, std::vector<std::uint64_t>& hashes) {
  while (world.step_count() < until) {
    const std::uint64_t step = world.step_count();
    const api::Ticket ticket = step + 1;
    if (step == 0) {
      for (int robot = 0; robot < 2; ++robot) {
        world.apply(ticket, api::RobotCommand{robot, api::InitRobot{}, {}});
        world.apply(
            ticket,
            api::RobotCommand{
                robot,
                api::MoveJoints{
                    {{.joint = 0, .position_rad = 0.6, .speed_rad_s = {}, .accel_rad_s2 = {}}}},
                {}});
      }
      world.apply(ticket, api::ConveyorCommand{.run = true, .forward = true, .speed_m_s = 0.1});
    }
    for (const Injection& injection : injections()) {
      if (injection.step == step) {
        ASSERT_TRUE(world.apply(ticket, api::FaultCommand(injection.fault)));
      }
    }
    if (step == 700) {
      ASSERT_TRUE(world.apply(ticket, api::FaultCommand(api::ReportEvent{"lunch"})));
      world.apply(ticket, api::RobotCommand{0, api::SetGripper{0}, {}});
    }
    if (step == 1000) {
      ASSERT_TRUE(world.apply(ticket, api::FaultCommand(api::EndFault{3})));
    }
    world.step();
    if (step % 20 == 19) hashes.push_back(world.state_hash());
  }
}

/// The faults and camera frames of a snapshot, as text.
std::string told(const world::World& world) {
  api::Snapshot now;
  world.write(now);
  std::string out;
  for (const auto& fault : now.faults->all) {
    out += std::to_string(fault.id) + " " + std::to_string(static_cast<int>(fault.state)) + " " +
           std::to_string(fault.begin_step.value_or(0)) + " " +
           std::to_string(fault.end_step.value_or(0)) + "\n";
  }
  for (const auto& robot : now.robots) {
    out += std::to_string(robot.vision.number) + "\n";
    for (const auto& seen : robot.vision.detections) {
      out += std::to_string(seen.body) + " " + std::to_string(seen.x_m) + " " +
             std::to_string(seen.rotation_rad) + "\n";
    }
  }
  return out;
}

TEST(FaultsAgain, TwiceTheSameAndOnFromASavedStateInTheMidst) {
  constexpr std::uint64_t kMiddle = 520, kEnd = 1400;  // with faults that wait, last and are over
  const auto scene = load_scene("aprs");
  std::vector<std::uint64_t> first, second, clean;
  world::World world(scene, 1);
  go_on(world, kMiddle, first);
  const world::WorldState saved = world.save();
  go_on(world, kEnd, first);
  const std::string end = told(world);

  world::World again(scene, 1);
  go_on(again, kEnd, second);
  EXPECT_EQ(second, first);
  EXPECT_EQ(told(again), end);

  world::World other(scene, 2);
  other.restore(saved);
  std::vector<std::uint64_t> rest;
  go_on(other, kEnd, rest);
  EXPECT_EQ(rest, std::vector(first.end() - static_cast<std::ptrdiff_t>(rest.size()), first.end()));
  EXPECT_EQ(told(other), end);

  // The faults have made a difference, and a world built anew has none of them.
  const world::World fresh(scene, 1);
  api::Snapshot now;
  fresh.write(now);
  EXPECT_EQ(now.faults, nullptr);
  int begun = 0;
  api::Snapshot last;
  world.write(last);
  for (const auto& fault : last.faults->all) begun += fault.begin_step ? 1 : 0;
  EXPECT_EQ(begun, 14);
}

}  // namespace
}  // namespace aprsim::test
