// Scenarios that pages edit: the shipped ones, and checks by the daemon's own reader.
#include "server/drafts/scenario_checker.hpp"

#include <algorithm>
#include <filesystem>
#include <future>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/temporary_directory.hpp"
#include "world/base/yaml/yaml_tree.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim {
namespace {

namespace fs = std::filesystem;

std::shared_ptr<const scene::Scene> loaded(const std::string& name) {
  return std::make_shared<const scene::Scene>(
      scene::load_scene(name, scene::default_data_paths()).value());
}

Result<web::ScenarioCheck> checked(server::ScenarioChecker& checker, const std::string& text) {
  auto answer = std::make_shared<std::promise<Result<web::ScenarioCheck>>>();
  auto coming = answer->get_future();
  checker.check(text, [answer](Result<web::ScenarioCheck> check) { answer->set_value(check); });
  return coming.get();
}

class ScenarioDrafts : public ::testing::Test {
 protected:
  std::shared_ptr<const scene::Scene> present = loaded("aprs");
  server::ScenarioChecker checker{[this] { return present; }};
};

TEST_F(ScenarioDrafts, BeginWithTheShippedOnes) {
  const auto all = checker.find("").value();
  EXPECT_EQ(all.scene, "aprs");
  EXPECT_EQ(all.text, "");
  ASSERT_GT(all.names.size(), 20U);
  for (const std::string& name : all.names) {
    EXPECT_EQ(
        checker.find(name).value().text,
        yaml::read_text(scene::default_data_paths().scenarios + "/" + name + ".yaml").value());
  }
}

TEST_F(ScenarioDrafts, AreNoFiles) {
  for (const char* name : {"../scenes/aprs", "/etc/hostname", "clean_2017.yaml", "nothing", ".."}) {
    const auto found = checker.find(name);
    ASSERT_FALSE(found) << name;
    EXPECT_EQ(found.error().code, ErrorCode::kNotFound) << name;
  }
}

TEST_F(ScenarioDrafts, RunWhereTheySuitTheCell) {
  const auto of = [&](const std::string& name) {
    return checked(checker, checker.find(name).value().text).value();
  };
  const auto suits = of("urgent_with_slow_robot");
  EXPECT_TRUE(suits.problems.empty());
  EXPECT_EQ(suits.run_refusal, "");
  EXPECT_EQ(suits.kits, 3U);
  EXPECT_EQ(suits.faults, 2U);
  EXPECT_EQ(suits.time_limit_s, 500);
  EXPECT_TRUE(of("belt_supply").run_refusal.starts_with("A running cell keeps its own parts"));
  EXPECT_TRUE(of("clean_2024").run_refusal.starts_with("It is for the scene aprs_2024"));
}

TEST_F(ScenarioDrafts, SuitTheSceneThatTheCellHasNow) {
  const auto text = checker.find("clean_2024").value().text;
  EXPECT_TRUE(checked(checker, text).value().run_refusal.starts_with("It is for the scene"));
  present = loaded("aprs_2024");
  EXPECT_EQ(checker.find("").value().scene, "aprs_2024");
  EXPECT_EQ(checked(checker, text).value().run_refusal, "");
  const auto before = checked(checker, checker.find("urgent_with_slow_robot").value().text).value();
  EXPECT_EQ(before.run_refusal,
            "It is for the scene aprs, and this cell has another one. Save it, and use `aprsim "
            "scenario run FILE`.");
}

TEST_F(ScenarioDrafts, BeginWithTheFirstSceneWhereThePresentOneHasNoFile) {
  auto sent = std::make_shared<scene::Scene>(*present);
  sent->file = fs::path(present->file).parent_path() / "a_text_that_was_sent.yaml";
  present = sent;
  EXPECT_EQ(checker.find("").value().scene, "aprs");
  const auto check = checked(checker, checker.find("urgent_with_slow_robot").value().text).value();
  EXPECT_TRUE(check.problems.empty());
  EXPECT_TRUE(check.run_refusal.starts_with("It is for the scene aprs"));
}

TEST_F(ScenarioDrafts, AreRefusedByTheReader) {
  const auto wrong = checked(checker, "description: no\nscene: aprs\norder: []\n").value();
  ASSERT_FALSE(wrong.problems.empty());
  EXPECT_TRUE(wrong.problems[0].message.starts_with("scenario text:3:1: order"))
      << wrong.problems[0].message;
  EXPECT_FALSE(checked(checker, "{").value().problems.empty());
  EXPECT_FALSE(checked(checker, "").value().problems.empty());
}

TEST_F(ScenarioDrafts, AreDrawnOnce) {
  const auto wide = checked(checker,
                            "description: trays that vary too much\nscene: aprs\norders: []\n"
                            "vary: {tray_xy_m: 1}\n")
                        .value();
  ASSERT_EQ(wide.problems.size(), 1U);
  EXPECT_EQ(wide.problems[0].field, "vary");
}

TEST_F(ScenarioDrafts, AreRefusedAfterTheEnd) {
  checker.stop();
  const auto late = checked(checker, "");
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ErrorCode::kUnavailable);
}

TEST(ScenarioDraftsOfAnOwnScene, NameItsFile) {
  const test::TemporaryDirectory directory;
  const auto paths = scene::default_data_paths();
  const std::string file = directory.write(
      "own.yaml", scene::self_contained(paths.scenes + "/empty_belt.yaml", paths).value());
  server::ScenarioChecker checker([scene = loaded(file)] { return scene; });
  EXPECT_EQ(checker.find("").value().scene, file);
  const auto check =
      checked(checker, "description: mine\nscene: " + file + "\norders: []\n").value();
  EXPECT_TRUE(check.problems.empty()) << check.problems[0].message;
  EXPECT_EQ(check.run_refusal, "");
}

}  // namespace
}  // namespace aprsim
