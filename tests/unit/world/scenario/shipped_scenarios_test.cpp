#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "world/api/faults/fault_kinds.hpp"
#include "world/scenario/plan.hpp"
#include "world/scenario/scenario_reader.hpp"

namespace aprsim::scenario {
namespace {

std::vector<std::string> shipped() {
  return scene::names_in(scene::default_data_paths().scenarios);
}

class ShippedScenarios : public testing::TestWithParam<std::string> {};

TEST_P(ShippedScenarios, CanBePlanned) {
  const auto paths = scene::default_data_paths();
  const auto scenario = load_scenario(GetParam(), paths);
  ASSERT_TRUE(scenario.has_value()) << scenario.error().message;
  EXPECT_FALSE(scenario->expected.empty());
  const auto summary = summarize_scenario(GetParam(), paths);
  ASSERT_TRUE(summary.has_value()) << summary.error().message;
  EXPECT_EQ(summary->description, scenario->description);
  EXPECT_EQ(summary->scene_file, scenario->scene_file);
  EXPECT_EQ(summary->changes_parts, scenario->changes_parts);
  EXPECT_LE(scenario->description.size(), 110U);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const auto made = plan(*scenario, seed, paths);
    EXPECT_TRUE(made.has_value()) << made.error().message;
  }
}

INSTANTIATE_TEST_SUITE_P(All, ShippedScenarios, testing::ValuesIn(shipped()),
                         [](const auto& test) { return test.param; });

TEST(ShippedScenarios, SayWhetherTheyHavePartsOfTheirOwn) {
  const auto paths = scene::default_data_paths();
  EXPECT_TRUE(summarize_scenario("insufficient_parts", paths)->changes_parts) << "it removes some";
  EXPECT_TRUE(summarize_scenario("belt_supply", paths)->changes_parts) << "it puts some in";
  EXPECT_FALSE(summarize_scenario("clean_2017", paths)->changes_parts);
  EXPECT_FALSE(summarize_scenario("no_such_scenario", paths).has_value());
}

TEST(ShippedScenarios, HaveAFaultOfEachFamily) {
  using faults::Kind;
  std::set<Kind> kinds;
  for (const auto& name : shipped()) {
    const auto scenario = load_scenario(name, scene::default_data_paths());
    ASSERT_TRUE(scenario.has_value()) << scenario.error().message;
    for (const auto& fault : scenario->faults) kinds.insert(faults::find(fault.kind)->kind);
  }
  // First and last kind of each family, in the order of the table.
  const std::vector<std::pair<Kind, Kind>> families = {
      {Kind::kRobotBreakdown, Kind::kToolOffset},
      {Kind::kGripperPressureLoss, Kind::kGripperDrops},
      {Kind::kBeltJam, Kind::kPhotoEyeStuckOff},
      {Kind::kPartMissing, Kind::kForeignObject},
      {Kind::kCameraOutage, Kind::kCameraFlipsTrays},
      {Kind::kCrclDrop, Kind::kCrclSlow},
      {Kind::kModbusExceptions, Kind::kModbusRefused}};
  for (const auto& [first, last] : families) {
    EXPECT_TRUE(std::ranges::any_of(kinds, [&, begin = first, end = last](Kind kind) {
      return kind >= begin && kind <= end;
    })) << faults::info(first).name;
  }
  EXPECT_GE(shipped().size(), 16U);
}

}  // namespace
}  // namespace aprsim::scenario
