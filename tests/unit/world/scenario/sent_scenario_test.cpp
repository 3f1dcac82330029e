// Scenarios from outside: what they may name, and all their errors with line and key.
#include <gtest/gtest.h>

#include "world/base/yaml/yaml_tree.hpp"
#include "world/scenario/scenario_reader.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::scenario {
namespace {

const SentScope kScope{"/lab/cell.yaml"};

ExaminedScenario examined(const std::string& text, const SentScope& scope = kScope) {
  return examine_sent_scenario(text, scope, scene::default_data_paths());
}

std::string scenario_with(const std::string& keys) {
  return "description: one kit\norders:\n  - {name: kit, tray: sku_kit_m2l1_vessel}\n" + keys;
}

TEST(SentScenario, IsReadAsAFile) {
  const auto paths = scene::default_data_paths();
  for (const std::string& name : scene::names_in(paths.scenarios)) {
    const auto text = yaml::read_text(paths.scenarios + "/" + name + ".yaml").value();
    const auto sent = examined(text);
    ASSERT_TRUE(sent.scenario) << name << ": " << sent.errors.front().message;
    const auto loaded = load_scenario(name, paths).value();
    EXPECT_EQ(sent.scenario->scene_text, loaded.scene_text) << name;
    EXPECT_EQ(sent.scenario->orders.size(), loaded.orders.size()) << name;
    EXPECT_EQ(sent.scenario->faults.size(), loaded.faults.size()) << name;
  }
}

TEST(SentScenario, HasAllItsErrorsWithLineAndKey) {
  const auto sent = examined(
      "description: two mistakes\nscene: aprs\norders: []\nfaults:\n"
      "  - {kind: robot-slo, target: fanuc}\n  - {kind: robot-slow, target: nobody}\n");
  EXPECT_FALSE(sent.scenario);
  ASSERT_EQ(sent.errors.size(), 2U);
  EXPECT_TRUE(sent.errors[0].message.starts_with("scenario text:5:12: faults[0].kind"))
      << sent.errors[0].message;
  EXPECT_TRUE(sent.errors[1].message.starts_with("scenario text:6:32: faults[1].target"))
      << sent.errors[1].message;
}

TEST(SentScenario, NamesNoFiles) {
  for (const char* scene : {"/etc/hostname", "../scenes/aprs.yaml", "cell.yaml", "./aprs"}) {
    const auto sent = examined(scenario_with(std::string("scene: ") + scene + "\n"));
    ASSERT_FALSE(sent.errors.empty()) << scene;
    EXPECT_TRUE(sent.errors[0].message.ends_with(
        "expected a shipped scene, or the daemon's: /lab/cell.yaml"))
        << sent.errors[0].message;
  }
  const auto with_cell = examined(scenario_with("scene: aprs\ncell: ../secret.toml\n"));
  ASSERT_EQ(with_cell.errors.size(), 1U);
  EXPECT_EQ(with_cell.errors[0].field, "cell");
  EXPECT_TRUE(examined(scenario_with("scene: aprs\ncell: aprs\n")).scenario);
}

TEST(SentScenario, MayNameTheScenesOfTheDaemon) {
  const std::string file = scene::default_data_paths().scenes + "/aprs.yaml";
  const std::string text = scenario_with("scene: " + file + "\n");
  EXPECT_FALSE(examined(text).scenario);
  EXPECT_TRUE(examined(text, {file}).scenario);
}

TEST(SentScenario, HasOptionsOfTheControllerThatConcernNoFiles) {
  for (const char* option :
       {"--report", "--rep", "--report=/tmp/x", "--actions", "--order", "-x", "--robots=fanuc"}) {
    const auto sent =
        examined(scenario_with(std::string("scene: aprs\ncontroller: [") + option + ", x]\n"));
    ASSERT_EQ(sent.errors.size(), 1U) << option;
    EXPECT_EQ(sent.errors[0].field, "controller[0]") << option;
  }
  EXPECT_TRUE(examined(scenario_with("scene: aprs\ncontroller: [--robots, fanuc]\n")).scenario);
}

}  // namespace
}  // namespace aprsim::scenario
