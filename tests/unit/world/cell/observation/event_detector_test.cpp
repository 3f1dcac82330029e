// Detection of the cell's events, step by step.

#include "world/cell/observation/event_detector.hpp"

#include <algorithm>
#include <map>

#include <gtest/gtest.h>

#include "tests/support/eventually.hpp"
#include "tests/support/pick_place.hpp"
#include "tests/unit/world/faults/fault_cell.hpp"
#include "world/runtime/simulation.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;
using What = api::CellEventKind;
using Events = std::vector<api::CellEvent>;

/// Takes what has been found.
void take_events(world::World& world, Events& out) {
  Events& found = *world.events();
  out.insert(out.end(), std::make_move_iterator(found.begin()),
             std::make_move_iterator(found.end()));
  found.clear();
}

std::vector<api::CellEvent> events_of(const Events& events, What kind) {
  Events out;
  std::ranges::copy_if(events, std::back_inserter(out),
                       [kind](const auto& event) { return event.kind == kind; });
  return out;
}

std::string event_line(const api::CellEvent& event) {
  std::string text =
      std::to_string(event.step) + " " + std::to_string(static_cast<int>(event.kind));
  for (const auto& name : event.names) text += " " + name;
  return text + " (" + event.text + ") " + std::to_string(event.robot) + " " +
         std::to_string(event.number);
}

std::vector<std::string> event_lines(const Events& events) {
  std::vector<std::string> out;
  std::ranges::transform(events, std::back_inserter(out), event_line);
  return out;
}

TEST(EventDetector, ReportsAPickAndPlaceInItsOrder) {
  CellScript cell(load_scene("aprs"));
  cell.world.watch_events();
  const auto report = pick_and_place(cell, 0, "part_large_gear_1", "kit_m2l1_vessel_1", "lg_1", 0);
  ASSERT_TRUE(report.resting);
  cell.advance(1000);
  Events events;
  take_events(cell.world, events);

  const auto grasped = events_of(events, What::kGrasped),
             released = events_of(events, What::kReleased);
  ASSERT_EQ(grasped.size(), 1u);
  EXPECT_EQ(grasped[0].names, (std::vector<std::string>{"fanuc", "part_large_gear_1"}));
  EXPECT_EQ(grasped[0].robot, 0);
  ASSERT_EQ(released.size(), 1u);
  EXPECT_EQ(released[0].names, grasped[0].names);
  EXPECT_EQ(released[0].text, "");
  EXPECT_LT(grasped[0].step, released[0].step);
  EXPECT_EQ(released[0].time, released[0].step * 1ms);

  // Every command begins and is done, in turn.
  api::Ticket next = 1;
  for (const auto& event : events) {
    if (event.kind == What::kCommandBegun) {
      EXPECT_EQ(event.number, next) << event_line(event);
    }
    if (event.kind == What::kCommandDone) {
      EXPECT_EQ(event.number, next++) << event_line(event);
    }
    EXPECT_NE(event.kind, What::kCommandFailed) << event_line(event);
    EXPECT_NE(event.kind, What::kCommandReplaced) << event_line(event);
  }
  EXPECT_GT(next, 15u);

  // The fingers touch the gear before it is held, and leave it; it leaves one tray for another.
  const auto about = [&](What kind, const std::string& a, const std::string& b) {
    return std::ranges::count_if(events, [&](const auto& event) {
      return event.kind == kind && event.names.size() == 2 &&
             std::ranges::count(event.names, a) == 1 && std::ranges::count(event.names, b) == 1;
    });
  };
  EXPECT_EQ(about(What::kContactBegun, "fanuc", "part_large_gear_1"), 2);
  EXPECT_EQ(about(What::kContactEnded, "fanuc", "part_large_gear_1"), 2);
  EXPECT_EQ(about(What::kContactBegun, "part_large_gear_1", "kit_m2l1_vessel_1"), 1);
  EXPECT_EQ(about(What::kContactEnded, "part_large_gear_1", "kit_m2l1_vessel_1"), 0);
  // Initial contacts are no events, and nothing rattles.
  EXPECT_LT(events_of(events, What::kContactBegun).size(), 12u);
  if (HasFailure()) {
    for (const auto& text : event_lines(events)) std::printf("%s\n", text.c_str());
  }
}

/// The demo of both robots on a fixed script goes on from a saved state with the same events.
TEST(EventDetector, GoesOnFromASavedStateWithTheSameEvents) {
  const auto scene = load_scene("aprs");
  CellScript cell(scene);
  cell.world.watch_events();
  Events before, after;
  std::optional<world::WorldState> state;
  int steps = 0;
  cell.advance(300);
  const auto strike = [](world::World& world) {
    world.apply(
        500,
        api::ConveyorCommand{
            .run = true, .forward = {}, .speed_m_s = 0.2, .emergency_stop = {}, .watchdog_s = {}});
    EXPECT_TRUE(world.apply(
        501,
        api::FaultCommand(api::InjectFault{
            "part-stray", "part_large_gear_1", {{"x", 0.4}, {"y", 0.1}, {"z", 1.2}}, {}, {}})));
  };
  strike(cell.world);
  // Saved while contacts are about to be told as ended.
  for (; steps < 3000; ++steps) {
    cell.advance();
    if (!state && !cell.world.save().apart.empty()) {
      state = cell.world.save();
      take_events(cell.world, before);
    }
  }
  take_events(cell.world, after);
  ASSERT_TRUE(state);
  ASSERT_FALSE(events_of(after, What::kContactEnded).empty());

  world::World other(scene, 9);
  other.watch_events();
  other.restore(*state);
  while (other.step_count() < cell.world.step_count()) other.step();
  Events again;
  take_events(other, again);
  EXPECT_EQ(event_lines(again), event_lines(after));
  EXPECT_EQ(other.state_hash(), cell.world.state_hash());
}

class DetectedEvents : public testing::Test {
 protected:
  DetectedEvents() { cell.world.watch_events(); }
  [[nodiscard]] Events of(What kind) {
    take_events(cell.world, events);
    return events_of(events, kind);
  }
  FaultCell cell;
  Events events;
};

TEST_F(DetectedEvents, ReportsFaultsWithTheirNumbers) {
  const auto id = cell.inject("protective-stop", "motoman");
  cell.advance(3);
  const auto begun = of(What::kFaultBegun), ended = of(What::kFaultEnded),
             stops = of(What::kProtectiveStop);
  ASSERT_EQ(begun.size(), 1u);
  EXPECT_EQ(begun[0].number, id);
  EXPECT_EQ(begun[0].names, std::vector<std::string>{"motoman"});
  EXPECT_EQ(begun[0].text, "protective-stop");
  EXPECT_EQ(begun[0].robot, 1);
  ASSERT_EQ(ended.size(), 1u);
  ASSERT_EQ(stops.size(), 1u);
  EXPECT_EQ(stops[0].names, std::vector<std::string>{"motoman"});
  EXPECT_NE(stops[0].text.find("Protective stop"), std::string::npos);
  // No command failed, so none is named.
  const auto failed = of(What::kCommandFailed);
  ASSERT_EQ(failed.size(), 1u);
  EXPECT_EQ(failed[0].text, stops[0].text);
}

TEST_F(DetectedEvents, ReportsReportedEvents) {
  ASSERT_TRUE(cell.world.apply(1, api::FaultCommand(api::ReportEvent{"order-submitted"})));
  const auto reported = of(What::kReported);
  ASSERT_EQ(reported.size(), 1u);
  EXPECT_EQ(reported[0].text, "order-submitted");
}

TEST_F(DetectedEvents, ReportsTripsOfTheDriveBetweenTwoSteps) {
  const auto stop = [&](bool engaged, bool reset) {
    cell.world.apply(1, api::ConveyorCommand{.run = {},
                                             .forward = {},
                                             .speed_m_s = {},
                                             .emergency_stop = engaged,
                                             .fault_reset = reset,
                                             .watchdog_s = {}});
  };
  stop(true, false);
  stop(false, true);
  cell.advance(2);
  const auto trips = of(What::kDriveTripped);
  ASSERT_EQ(trips.size(), 1u);
  EXPECT_EQ(trips[0].text, "emergency stop");
}

TEST_F(DetectedEvents, ReportsReplacedAndRefusedCommands) {
  cell.act(0, api::InitRobot{});
  cell.tell(0, turn(0, 0.5));
  cell.advance(10);
  cell.tell(0, turn(0, -0.5));
  cell.advance(10);
  cell.tell(1, turn(0, 0.5));  // not initialized
  take_events(cell.world, events);
  const auto replaced = events_of(events, What::kCommandReplaced);
  ASSERT_EQ(replaced.size(), 1u);
  EXPECT_EQ(replaced[0].number, 1'000'001u);
  EXPECT_EQ(replaced[0].text, "by command 1000002");
  const auto failed = events_of(events, What::kCommandFailed);
  ASSERT_EQ(failed.size(), 1u);
  EXPECT_EQ(failed[0].number, 1'000'003u);
  EXPECT_EQ(failed[0].robot, 1);
  EXPECT_EQ(failed[0].text.find("move joints: not initialized"), 0u) << failed[0].text;
}

TEST_F(DetectedEvents, ReportsDroppedAndLostGears) {
  cell.grasp("part_large_gear_1");
  cell.inject("gripper-drops", "fanuc", {{"after", 0.0}, {"open", 0.5}});
  cell.advance(600);
  const auto released = of(What::kReleased);
  ASSERT_EQ(released.size(), 1u);
  EXPECT_EQ(released[0].text, "the gripper was not told to open");
  cell.inject("part-missing", "part_large_gear_1");
  cell.advance(2);
  const auto lost = of(What::kLost);
  ASSERT_EQ(lost.size(), 1u);
  EXPECT_EQ(lost[0].names, std::vector<std::string>{"part_large_gear_1"});
}

/// Every simplification mode reports each body that joins a group, and releases only such bodies.
TEST(EventDetector, ReportsTiesInEveryMode) {
  using Simplified = scene::Simplification;
  for (const Simplified mode :
       {Simplified::kVirtualJoints, Simplified::kMerge, Simplified::kDormant}) {
    auto scene = *load_scene("aprs");
    scene.physics.simplification = mode;
    CellScript cell(std::make_shared<const scene::Scene>(std::move(scene)));
    cell.world.watch_events();
    cell.advance(1500);
    Events events;
    take_events(cell.world, events);
    EXPECT_FALSE(events_of(events, What::kMerged).empty());
    const auto report =
        pick_and_place(cell, 0, "part_large_gear_1", "kit_m2l1_vessel_1", "lg_1", 0);
    EXPECT_TRUE(report.resting);
    cell.advance(1500);
    take_events(cell.world, events);
    std::map<std::string, int> ties;
    for (const auto& event : events) {
      if (event.kind != What::kMerged && event.kind != What::kWoken) continue;
      const bool tied = event.kind == What::kMerged;
      // The first body of a merger or joint is tied; all of a sleeping group are.
      const std::size_t count = event.text == "dormant" ? event.names.size() : 1;
      for (std::size_t i = 0; i < count; ++i) {
        int& now = ties[event.text + " " + event.names[i]];
        now += tied ? 1 : -1;
        EXPECT_TRUE(now == 0 || now == 1) << event_line(event);
      }
    }
    EXPECT_FALSE(events_of(events, What::kWoken).empty());
  }
}

TEST(CellEvents, AreNumberedWithoutGapsAcrossResetsAndAtMaximumSpeed) {
  world::Simulation simulation(load_scene("aprs"), {.speed = std::nullopt});
  simulation.start();
  const auto submit = [&](auto body) {
    const auto ticket = simulation.submit({.endpoint = 1, .body = body});
    ASSERT_TRUE(ticket);
    ASSERT_TRUE(eventually([&] { return simulation.latest()->applied >= *ticket; }));
  };
  submit(api::RobotCommand{0, api::InitRobot{}, {}});
  submit(api::SimulationCommand(api::SaveState{"here"}));
  submit(api::SimulationCommand(api::Reset{}));
  submit(api::RobotCommand{1, api::InitRobot{}, {}});
  submit(api::SimulationCommand(api::LoadState{"here"}));
  submit(api::SimulationCommand(api::Pause{}));
  const auto latest = simulation.latest()->last_event;
  ASSERT_TRUE(eventually([&] { return simulation.events().after(0, 1).latest >= latest; }));
  const auto batch = simulation.events().after(0, 256);
  ASSERT_FALSE(batch.events.empty());
  EXPECT_EQ(batch.oldest, 1u);
  std::vector<std::string> resets;
  for (std::size_t i = 0; i < batch.events.size(); ++i) {
    EXPECT_EQ(batch.events[i]->sequence, i + 1);
    if (batch.events[i]->kind == What::kReset) resets.push_back(batch.events[i]->text);
  }
  EXPECT_EQ(resets, (std::vector<std::string>{"", "here"}));
  EXPECT_EQ(batch.events.back()->epoch, 2u);
}

}  // namespace
}  // namespace aprsim::test
