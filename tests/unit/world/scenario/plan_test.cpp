#include "world/scenario/plan.hpp"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "tests/support/temporary_directory.hpp"
#include "world/scenario/scenario_reader.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::scenario {
namespace {

constexpr const char* kVaried = R"(description: everything varies
scene: aprs
orders: [{name: kit, tray: sku_kit_m2l1_vessel}]
faults: [{kind: belt-jam, at_s: [10, 20]}]
kill_controller: [{at_s: [30, 40]}, {at_s: 5}]
vary:
  tray_xy_m: 0.003
  tray_yaw_deg: 2
  gear_yaw_deg: 180
  friction: 0.2
  gear_mass: 0.1
  vision_position_noise_m: [0.00003, 0.00005]
  vision_rotation_noise_deg: [0.1, 0.3]
)";

class PlanTest : public testing::Test {
 protected:
  [[nodiscard]] Scenario read(const std::string& text) const {
    auto scenario = load_scenario(directory_.write("varied.yaml", text), paths_);
    if (!scenario) throw std::runtime_error(scenario.error().message);
    return *std::move(scenario);
  }
  [[nodiscard]] Plan plan_of(const Scenario& scenario, std::uint64_t seed) const {
    auto made = plan(scenario, seed, paths_);
    if (!made) throw std::runtime_error(made.error().message);
    return *std::move(made);
  }

  test::TemporaryDirectory directory_;
  scene::DataPaths paths_ = scene::default_data_paths();
};

TEST_F(PlanTest, IsAFunctionOfScenarioAndSeed) {
  const Scenario scenario = read(kVaried);
  std::set<std::string> scenes;
  std::set<double> times, kills;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Plan first = plan_of(scenario, seed), again = plan_of(scenario, seed);
    EXPECT_EQ(first.scene_text, again.scene_text);
    EXPECT_EQ(first.faults.at(0).at_s, again.faults.at(0).at_s);
    EXPECT_EQ(first.faults.at(0).at_s->at(0), first.faults.at(0).at_s->at(1));
    scenes.insert(first.scene_text);
    times.insert(first.faults.at(0).at_s->at(0));
    EXPECT_EQ(first.kills_s, again.kills_s);
    ASSERT_EQ(first.kills_s.size(), 2U);
    EXPECT_EQ(first.kills_s[0], 5);
    kills.insert(first.kills_s[1]);
  }
  EXPECT_EQ(scenes.size(), 5U);
  EXPECT_EQ(times.size(), 5U);
  EXPECT_EQ(kills.size(), 5U);
  EXPECT_GE(*kills.begin(), 30);
  EXPECT_LE(*kills.rbegin(), 40);
  EXPECT_GE(*times.begin(), 10);
  EXPECT_LE(*times.rbegin(), 20);
}

TEST_F(PlanTest, VariesWithinItsBounds) {
  const Scenario scenario = read(kVaried);
  const scene::Scene& base = scenario.scene;
  double farthest = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Plan made = plan_of(scenario, seed);
    EXPECT_EQ(made.scene.seed, seed);
    ASSERT_EQ(made.scene.trays.size(), base.trays.size());
    for (std::size_t i = 0; i < base.trays.size(); ++i) {
      const Eigen::Vector3d off = made.scene.trays[i].X_WP.p - base.trays[i].X_WP.p;
      EXPECT_LE(off.cwiseAbs().maxCoeff(), 0.003 + 1e-12);
      EXPECT_NEAR(off.z(), 0, 1e-12);
      EXPECT_LE(made.scene.trays[i].X_WP.q.angularDistance(base.trays[i].X_WP.q), 0.035);
      EXPECT_EQ(made.scene.trays[i].gears, base.trays[i].gears);
      farthest = std::max(farthest, off.cwiseAbs().maxCoeff());
    }
    const double factor = made.scene.physics.friction.robot / base.physics.friction.robot;
    EXPECT_GE(factor, 0.8);
    EXPECT_LE(factor, 1.2);
    EXPECT_DOUBLE_EQ(made.scene.physics.friction.gear_tray / base.physics.friction.gear_tray,
                     factor);
    for (const auto& [name, type] : made.scene.gear_types) {
      const double mass = type.mass_kg / base.gear_types.at(name).mass_kg;
      EXPECT_NEAR(mass, 1, 0.1);
      EXPECT_NE(mass, 1);
    }
    for (const auto& robot : made.scene.robots) {
      EXPECT_GE(robot.vision.position_noise_m, 3e-5);
      EXPECT_LE(robot.vision.position_noise_m, 5e-5);
    }
  }
  EXPECT_GT(farthest, 0.0025) << "the bounds are used";
}

TEST_F(PlanTest, ChangesNothingThatDoesNotVary) {
  const Scenario scenario = read(
      "description: as it is\nscene: aprs_2024\norders: [{name: k, tray: sku_kit_m2l1_vessel}]\n");
  const Plan made = plan_of(scenario, 7);
  const auto plain = scene::load_scene("aprs_2024", paths_);
  ASSERT_TRUE(plain.has_value());
  ASSERT_EQ(made.scene.gears.size(), plain->gears.size());
  for (std::size_t i = 0; i < plain->gears.size(); ++i) {
    EXPECT_EQ(made.scene.gears[i].X_WP.p, plain->gears[i].X_WP.p);
    EXPECT_EQ(made.scene.gears[i].X_WP.q.coeffs(), plain->gears[i].X_WP.q.coeffs());
  }
  EXPECT_EQ(made.scene.robots[0].model_file, plain->robots[0].model_file);
  EXPECT_EQ(made.scene.robots[0].gripper.force_n, plain->robots[0].gripper.force_n);
}

TEST_F(PlanTest, ItsSceneIsAFileOfItsOwn) {
  const Plan made = plan_of(read(kVaried), 3);
  const test::TemporaryDirectory elsewhere;
  const auto scene = scene::load_scene(elsewhere.write("scene.yaml", made.scene_text),
                                       {elsewhere.path(), paths_.models});
  ASSERT_TRUE(scene.has_value()) << scene.error().message;
  ASSERT_EQ(scene->gears.size(), made.scene.gears.size());
  EXPECT_EQ(scene->gears[3].X_WP.q.coeffs(), made.scene.gears[3].X_WP.q.coeffs());
}

TEST_F(PlanTest, VariationThatFitsNowhereIsAnError) {
  const auto made = plan(read(R"(description: trays in each other
scene: aprs
orders: [{name: kit, tray: sku_kit_m2l1_vessel}]
vary: {tray_yaw_deg: 180, tray_xy_m: 0.5}
)"),
                         1, paths_);
  ASSERT_FALSE(made.has_value());
  EXPECT_NE(made.error().message.find("expected less variation"), std::string::npos);
}

TEST(Plan, SaysWhatWasDrawnAndNothingElse) {
  const auto paths = scene::default_data_paths();
  const auto pick = load_scenario("pick", paths);
  ASSERT_TRUE(pick.has_value()) << pick.error().message;
  EXPECT_EQ(pick->program, "pick");
  const auto one = plan(*pick, 1, paths), other = plan(*pick, 2, paths);
  ASSERT_TRUE(one && other);
  EXPECT_LE(std::abs(one->drawn.at("friction_share")), 0.3);
  EXPECT_NE(one->drawn.at("friction_share"), other->drawn.at("friction_share"));
  const double noise_m = one->drawn.at("fanuc.position_noise_m");
  EXPECT_GE(noise_m, 0.00003);
  EXPECT_LE(noise_m, 0.0006);
  EXPECT_EQ(one->scene.robots[0].vision.position_noise_m, noise_m);
  EXPECT_EQ(one->drawn.size(), other->drawn.size());
  const auto clean = load_scenario("cannot_be_done", paths);
  ASSERT_TRUE(clean.has_value());
  EXPECT_EQ(clean->program, "kitting");
}

}  // namespace
}  // namespace aprsim::scenario
