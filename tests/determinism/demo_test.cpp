// The cell at work, repeated: the same commands at the same steps give the same bits in every mode
// of contact simplification. Ten minutes of it: tests/benchmarks/run determinism.

#include <memory>
#include <ostream>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"
#include "tests/support/replay.hpp"

namespace aprsim::test {
namespace {

struct Case {
  const char* name;
  scene::Simplification mode;
  double seconds;
};
void PrintTo(const Case& shown, std::ostream* out) { *out << shown.name; }

class DemoReplay : public testing::TestWithParam<Case> {};

TEST_P(DemoReplay, RepeatsBitForBit) {
  auto scene = std::make_shared<scene::Scene>(*load_scene("aprs"));
  scene->physics.simplification = GetParam().mode;
  const Trace first = record_demo(scene, GetParam().seconds);
  EXPECT_GT(first.commands.size(), 12U) << "hardly anything happened";
  EXPECT_NE(first.hashes.front(), first.hashes.back());
  EXPECT_EQ(count_mismatches(first, replay_demo(scene, first)), 0);
}

INSTANTIATE_TEST_SUITE_P(Modes, DemoReplay,
                         testing::Values(Case{"off", scene::Simplification::kOff, 5},
                                         Case{"virtual_joints",
                                              scene::Simplification::kVirtualJoints, 6},
                                         Case{"merge", scene::Simplification::kMerge, 8},
                                         Case{"dormant", scene::Simplification::kDormant, 40}),
                         [](const auto& param) { return std::string(param.param.name); });

TEST(DemoReplay, AnotherCommandGivesOtherBits) {
  const auto scene = load_scene("aprs");
  const Trace first = record_demo(scene, 3);
  Trace changed = first;
  changed.commands.pop_back();
  EXPECT_GT(count_mismatches(first, replay_demo(scene, changed)), 0);
}

}  // namespace
}  // namespace aprsim::test
