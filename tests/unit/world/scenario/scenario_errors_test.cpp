#include <algorithm>
#include <ostream>

#include <gtest/gtest.h>

#include "tests/support/temporary_directory.hpp"
#include "world/scenario/scenario_reader.hpp"

namespace aprsim::scenario {
namespace {

constexpr const char* kGood = R"(description: one kit
scene: aprs
cell: aprs
controller: [--robots, fanuc]
remove: [part_small_gear_8]
supply:
  - {name: coming, type: sku_small_gear_vessel, xy_m: [-0.8, -0.45], gears: [slot_1]}
orders:
  - {name: first, tray: sku_kit_m2l1_vessel, slots: {lg_1: sku_part_large_gear}, deadline_s: 90}
  - {name: second, tray: sku_kit_s2l2_vessel, count: 2, priority: 1, when: submitted:first}
  - {name: third, tray: sku_kit_m2l1_vessel, when: fault:slow, cancel: {at_s: 40}}
faults:
  - {name: slow, kind: robot-slow, target: fanuc, at_s: [3, 9], for_s: 5, with: {share: 0.5}}
  - {kind: gripper-leak, target: fanuc, when: grasp:fanuc:2}
  - {kind: joint-weak, target: fanuc:6, when: event:first-submitted}
kill_controller: [{at_s: [7, 8]}]
vary: {tray_xy_m: 0.002, gear_yaw_deg: 180}
stop: {time_limit_s: 100, quiet_s: 20}
expect: {kits_right: 3, drops: {max: 0}}
scoring: {baseline_s: 60}
)";

/// One thing wrong: `from` becomes `to`. A '@' marks the place that the error must name.
struct Wrong {
  const char* name;
  const char* from;
  const char* to;
  const char* key;
  const char* message;  ///< begins so
};

std::ostream& operator<<(std::ostream& out, const Wrong& wrong) { return out << wrong.name; }

class ScenarioErrors : public testing::TestWithParam<Wrong> {};

TEST_P(ScenarioErrors, NameFilePlaceKeyAndWhatWasExpected) {
  const Wrong& wrong = GetParam();
  std::string text = kGood;
  const std::size_t from = text.find(wrong.from);
  ASSERT_NE(from, std::string::npos);
  text.replace(from, std::string(wrong.from).size(), wrong.to);
  const std::size_t at = text.find('@');
  ASSERT_NE(at, std::string::npos);
  text.erase(at, 1);
  const auto line =
      1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  const std::size_t line_start = at == 0 ? 0 : text.rfind('\n', at - 1) + 1;
  const test::TemporaryDirectory directory;
  const std::string file = directory.write("job.yaml", text);

  const auto scenario = load_scenario(file, scene::default_data_paths());

  ASSERT_FALSE(scenario.has_value());
  EXPECT_EQ(scenario.error().field, wrong.key);
  const std::string expected = file + ':' + std::to_string(line) + ':' +
                               std::to_string(at - line_start + 1) + ": " + wrong.key + ": " +
                               wrong.message;
  EXPECT_EQ(scenario.error().message.substr(0, expected.size()), expected);
}

INSTANTIATE_TEST_SUITE_P(
    All, ScenarioErrors,
    testing::Values(
        Wrong{"unknown_key", "stop:", "@halt: 3\nstop:", "halt", "found an unknown key"},
        Wrong{"no_scene", "scene: aprs\n", "scene: @mars\n", "scene", "found a scene that cannot"},
        Wrong{"nothing_to_remove", "[part_small_gear_8]", "[@part_9]", "remove[0]",
              "found \"part_9\", expected the name of a tray or gear in the scene"},
        Wrong{"supply_of_no_type", "type: sku_small_gear_vessel", "type: @bucket", "supply[0].type",
              "found \"bucket\", expected a type of tray"},
        Wrong{"supply_of_no_slot", "gears: [slot_1]", "gears: [@slot_9]", "supply[0].gears[0]",
              "found no slot \"slot_9\", expected one of slot_1"},
        Wrong{"kit_that_no_scene_has", "tray: sku_kit_m2l1_vessel, slots",
              "tray: @sku_kit_m3_vessel, slots", "orders[0].tray",
              "found no kit tray in the scene \"sku_kit_m3_vessel\", expected one of"},
        Wrong{"part_tray_is_no_kit", "tray: sku_kit_m2l1_vessel, slots",
              "tray: @sku_small_gear_vessel, slots", "orders[0].tray",
              "found no kit tray in the scene \"sku_small_gear_vessel\""},
        Wrong{"slot_that_no_kit_has", "{lg_1: sku", "{lg_9: @sku", "orders[0].slots.lg_9",
              "found no slot \"lg_9\", expected one of mg_1, mg_2, lg_1"},
        Wrong{"part_that_does_not_fit", "{lg_1: sku_part_large_gear}",
              "{lg_1: @sku_part_small_gear}", "orders[0].slots.lg_1",
              "found \"sku_part_small_gear\", expected sku_part_large_gear"},
        Wrong{"more_kits_than_trays", "  - {name: second, tray: sku_kit_s2l2_vessel, count: 2",
              "  - @{name: second, tray: sku_kit_s2l2_vessel, count: 3", "orders[1]",
              "found 3 kits of sku_kit_s2l2_vessel, expected at most 2, the trays in the scene"},
        Wrong{"two_orders_of_a_name", "name: second", "name: @first", "orders[1].name",
              "found a second order first"},
        Wrong{"negative_deadline", "deadline_s: 90", "deadline_s: @-90", "orders[0].deadline_s",
              "found -90, expected a number in (0, "},
        Wrong{"event_that_is_none", "when: submitted:first", "when: @tomorrow", "orders[1].when",
              "found \"tomorrow\", expected placed:N, submitted:ORDER or fault:NAME"},
        Wrong{"order_that_is_none", "when: submitted:first", "when: @submitted:zeroth",
              "orders[1].when", "found no order \"zeroth\""},
        Wrong{"fault_that_is_none", "when: fault:slow", "when: @fault:fast", "orders[2].when",
              "found no named fault \"fast\", expected one of slow"},
        Wrong{"unknown_fault", "kind: robot-slow", "kind: @robot-slwo", "faults[0].kind",
              "found no kind of fault \"robot-slwo\", expected one of"},
        Wrong{"no_target", "{name: slow, kind: robot-slow, target: fanuc,",
              "@{name: slow, kind: robot-slow,", "faults[0].target", "found nothing"},
        Wrong{"target_that_is_none", "kind: gripper-leak, target: fanuc",
              "kind: gripper-leak, target: @kuka", "faults[1].target",
              "found no robot \"kuka\", expected one of fanuc, motoman"},
        Wrong{"joint_that_is_none", "target: fanuc:6", "target: @fanuc:7", "faults[2].target",
              "found \"fanuc:7\", expected ROBOT:NUMBER with a joint from 1 to 6"},
        Wrong{"parameter_that_is_none", "{share: 0.5}", "{speed: @0.5}", "faults[0].with.speed",
              "found no parameter \"speed\", expected one of share"},
        Wrong{"parameter_too_big", "{share: 0.5}", "{share: @1.5}", "faults[0].with.share",
              "found 1.5, expected a number in [0, 1]"},
        Wrong{"negative_time", "at_s: [3, 9]", "at_s: @-3", "faults[0].at_s",
              "found -3, expected a number in [0, "},
        Wrong{"times_the_wrong_way_round", "at_s: [3, 9]", "at_s: @[9, 3]", "faults[0].at_s",
              "found a list, expected two numbers in rising order"},
        Wrong{"negative_time_of_a_kill", "at_s: [7, 8]", "at_s: [@-7, 8]",
              "kill_controller[0].at_s[0]", "found -7, expected a number"},
        Wrong{"kill_at_no_time", "{at_s: [7, 8]}", "{@when: placed:1}", "kill_controller[0].when",
              "found an unknown key"},
        Wrong{"trigger_without_object", "when: grasp:fanuc:2", "when: @grasp", "faults[1].when",
              "found \"grasp\", expected placed:TYPE[:ROBOT], grasp:ROBOT[:N]"},
        Wrong{"trigger_of_no_robot", "when: grasp:fanuc:2", "when: @grasp:kuka", "faults[1].when",
              "found no robot \"kuka\""},
        Wrong{"event_nobody_reports", "event:first-submitted", "@event:first-eaten",
              "faults[2].when", "found no event \"first-eaten\", expected one of order-announced"},
        Wrong{"time_and_trigger", "when: grasp:fanuc:2", "at_s: 1, when: @grasp:fanuc",
              "faults[1].when", "found both at_s and when, expected one of them"},
        Wrong{"span_of_what_is_over_at_once", "kind: gripper-leak, target: fanuc",
              "kind: protective-stop, target: fanuc, for_s: @3", "faults[1].for_s",
              "found 3, expected no duration: the fault is momentary"},
        Wrong{"too_much_variation", "tray_xy_m: 0.002", "tray_xy_m: @2", "vary.tray_xy_m",
              "found 2, expected a number in [0, 1]"},
        Wrong{"no_time_limit", "time_limit_s: 100", "time_limit_s: @0", "stop.time_limit_s",
              "found 0, expected a number in (0, "},
        Wrong{"measure_that_is_none", "kits_right: 3", "kits_left: @3", "expect.kits_left",
              "found no measure \"kits_left\", expected one of kits_ordered"},
        Wrong{"bounds_the_wrong_way_round", "drops: {max: 0}", "drops: {min: 2, max: @1}",
              "expect.drops.max", "found 1, expected at least min"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(ScenarioReader, TakesTheGoodOne) {
  const test::TemporaryDirectory directory;
  const auto scenario =
      load_scenario(directory.write("job.yaml", kGood), scene::default_data_paths());
  ASSERT_TRUE(scenario.has_value()) << scenario.error().message;
  EXPECT_EQ(scenario->name, "job");
  ASSERT_EQ(scenario->orders.size(), 3U);
  EXPECT_EQ(scenario->orders[0].slots.size(), 1U);
  EXPECT_EQ(scenario->orders[1].slots.size(), 4U) << "all slots without a word of them";
  EXPECT_EQ(std::get<OnSubmitted>(scenario->orders[1].announced).order, "first");
  EXPECT_EQ(std::get<OnFault>(scenario->orders[2].announced).fault, "slow");
  EXPECT_EQ(std::get<double>(*scenario->orders[2].cancelled), 40);
  ASSERT_EQ(scenario->faults.size(), 3U);
  EXPECT_EQ(scenario->faults[0].at_s->at(1), 9);
  EXPECT_EQ(std::get<faults::WhenGrasped>(*scenario->faults[1].when).count, 2U);
  EXPECT_EQ(scenario->expected.at("kits_right").max, 3);
  EXPECT_EQ(scenario->expected.at("drops").min, std::nullopt);
  const auto has = [&](const std::string& name) {
    return std::ranges::find(scenario->scene.gears, name, &scene::GearInstance::name) !=
           scenario->scene.gears.end();
  };
  EXPECT_FALSE(has("part_small_gear_8"));
  EXPECT_TRUE(has("part_small_gear_7"));
  EXPECT_TRUE(has("coming_slot_1"));
  EXPECT_FALSE(has("coming_slot_2"));
}

TEST(ScenarioReader, NamesTheNearestScenario) {
  const auto scenario = load_scenario("clean_2071", scene::default_data_paths());
  ASSERT_FALSE(scenario.has_value());
  EXPECT_NE(scenario.error().message.find("did you mean clean_2017?"), std::string::npos)
      << scenario.error().message;
}

}  // namespace
}  // namespace aprsim::scenario
