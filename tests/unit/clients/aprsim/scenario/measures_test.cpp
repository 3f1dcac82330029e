#include "clients/aprsim/scenario/measures.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/scenario/report.hpp"
#include "clients/aprsim/scenario/scores.hpp"

namespace aprsim::client {
namespace {

using Kind = BodyShape::Kind;

/// A kit tray of two slots at (1, 0, 0), a part tray far off with three gears, and one robot.
class MeasuresTest : public testing::Test {
 protected:
  static constexpr std::size_t kKit = 0, kBig = 2, kSmall = 3, kOther = 4;

  MeasuresTest() {
    shape_.robots = {"arm"};
    shape_.bodies = {
        {"kit", "kit_type", Kind::kKitTray, {{"a", "big", {0, 0, 0}}, {"b", "small", {0.1, 0, 0}}}},
        {"parts", "part_type", Kind::kPartTray, {{"p", "big", {0, 0, 0}}}},
        {"big_1", "big", Kind::kGear, {}},
        {"small_1", "small", Kind::kGear, {}},
        {"small_2", "small", Kind::kGear, {}}};
    sample_.robots.resize(1);
    sample_.bodies.resize(5);
    put(kKit, {1, 0, 0});
    put(1, {5, 0, 0});
    put(kBig, {5, 0, 0});
    put(kSmall, {6, 0, 0});
    put(kOther, {7, 0, 0});
    order_.name = "order";
    order_.tray = "kit_type";
    order_.slots = {{"a", "big"}, {"b", "small"}};
  }

  Measures measures() const { return Measures(shape_, {order_}); }

  void put(std::size_t body, const Eigen::Vector3d& at) {
    sample_.bodies[body].pose.translation() = at;
  }
  /// The next sample, `after_s` later.
  void step(Measures& measures, double after_s = 0.1) {
    sample_.time_s += after_s;
    measures.add(sample_);
  }
  void grasp(Measures& measures, std::optional<std::size_t> body) {
    sample_.robots[0].told_to_close = true;
    step(measures);
    sample_.robots[0].held = body;
    step(measures);
  }
  void release(Measures& measures) {
    sample_.robots[0].told_to_close = false;
    sample_.robots[0].held.reset();
    step(measures);
  }
  /// Takes a gear and puts it down.
  void carry(Measures& measures, std::size_t body, const Eigen::Vector3d& to) {
    grasp(measures, body);
    put(body, to);
    release(measures);
  }
  static double value(const Measures& measures, const char* name) {
    return measures.result({}).values.at(name);
  }

  CellShape shape_;
  scenario::Order order_;
  Sample sample_;
};

TEST_F(MeasuresTest, QuantilesLieBetweenValues) {
  EXPECT_EQ(quantile({3, 1, 2}, 0.5), 2);
  EXPECT_EQ(quantile({1, 2}, 0.5), 1.5);
  EXPECT_NEAR(quantile({0, 1, 2, 3, 4}, 0.95), 3.8, 1e-12);
  EXPECT_EQ(quantile({7}, 0.95), 7);
  EXPECT_EQ(quantile({}, 0.5), 0);
}

TEST_F(MeasuresTest, CountsGraspsFailuresAndRepetitions) {
  Measures m = measures();
  step(m);
  grasp(m, {});
  release(m);  // failed
  grasp(m, {});
  release(m);  // failed, at the same place
  grasp(m, kBig);
  release(m);  // repeated, and held
  sample_.robots[0].tool.translation().x() = 0.5;
  grasp(m, kSmall);
  release(m);
  EXPECT_EQ(value(m, "grasps"), 4);
  EXPECT_EQ(value(m, "grasps_failed"), 2);
  EXPECT_EQ(value(m, "grasps_repeated"), 2);
  EXPECT_EQ(value(m, "drops"), 0);
}

TEST_F(MeasuresTest, ADropIsALossWhileToldToHold) {
  Measures m = measures();
  step(m);
  grasp(m, kBig);
  sample_.robots[0].held.reset();
  put(kBig, {3, 0, 0});
  step(m);
  EXPECT_EQ(value(m, "drops"), 1);
  EXPECT_EQ(value(m, "parts_lost"), 1) << "it lies in no slot";
  release(m);
  carry(m, kBig, {5, 0, 0});
  EXPECT_EQ(value(m, "parts_lost"), 0) << "it is back in its tray";
  EXPECT_EQ(value(m, "placed"), 0) << "of a part tray";
}

TEST_F(MeasuresTest, PlacementsHaveTheirErrorInSpace) {
  Measures m = measures();
  step(m);
  carry(m, kBig, {1.0003, 0.0004, 0});
  carry(m, kSmall, {1.1, 0, 0.001});
  const Measured result = m.result({});
  ASSERT_EQ(result.placements.size(), 2U);
  EXPECT_EQ(result.placements[0].slot, "kit/a");
  EXPECT_EQ(result.placements[0].robot, "arm");
  EXPECT_NEAR(result.placements[0].error_m, 5e-4, 1e-12);
  EXPECT_NEAR(result.values.at("placement_p50_mm"), 0.75, 1e-9);
  EXPECT_NEAR(result.values.at("placement_p95_mm"), 0.975, 1e-9);
  EXPECT_NEAR(result.values.at("placement_max_mm"), 1, 1e-9);
}

TEST_F(MeasuresTest, RollingPartIsNotPlaced) {
  Measures m = measures();
  step(m);
  sample_.bodies[kBig].resting = false;
  carry(m, kBig, {1, 0, 0});
  EXPECT_EQ(m.placed(), 0U);
  sample_.bodies[kBig].resting = true;
  step(m);
  EXPECT_EQ(m.placed(), 1U);
}

TEST_F(MeasuresTest, MeasuresTurnInTheGripper) {
  Measures m = measures();
  step(m);
  grasp(m, kBig);
  const Eigen::AngleAxisd turn(0.3, Eigen::Vector3d::UnitZ());
  sample_.robots[0].tool.linear() = turn.toRotationMatrix();
  sample_.bodies[kBig].pose.linear() =
      (turn * Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitZ())).toRotationMatrix();
  step(m);
  put(kBig, {1, 0, 0});
  release(m);
  EXPECT_NEAR(value(m, "placement_yaw_p95_deg"), 0.02 * 180 / std::numbers::pi, 1e-9);
}

TEST_F(MeasuresTest, MeasuresMotionInTheLightCurtain) {
  Measures m = measures();
  sample_.robots[0].moving = true;
  step(m);
  sample_.curtain_broken = true;
  step(m, 1);  // somebody comes, at whatever time in between
  step(m, 2);
  sample_.robots[0].moving = false;
  step(m, 4);
  sample_.curtain_broken = false;
  sample_.robots[0].moving = true;
  step(m, 8);
  EXPECT_NEAR(value(m, "moved_in_curtain_s"), 2, 1e-12);
}

TEST_F(MeasuresTest, IntegratesWayPowerAndIdleness) {
  Measures m = measures();
  step(m);
  m.announced("order");
  sample_.robots[0] = {.moving = true, .power_w = 100};
  sample_.robots[0].tool.translation() = Eigen::Vector3d(0.3, 0.4, 0);
  step(m, 2);  // from 0 to 100 W
  sample_.robots[0].power_w = 60;
  step(m, 1);  // from 100 to 60 W
  sample_.robots[0] = {.tool = sample_.robots[0].tool};
  step(m, 1);  // from 60 to 0 W, standing
  EXPECT_NEAR(value(m, "energy_j"), 100 + 80 + 30, 1e-9);
  EXPECT_NEAR(value(m, "path_m"), 0.5, 1e-12);
  EXPECT_NEAR(value(m, "idle_share"), 0.25, 1e-12);
  EXPECT_NEAR(m.quiet_s(), 1, 1e-12);
}

TEST_F(MeasuresTest, JudgesAKitAsItIsWhenItIsSubmitted) {
  order_.deadline_s = 100;
  Measures m = measures();
  step(m);
  m.announced("order");
  EXPECT_EQ(m.open("order"), 1U);
  carry(m, kBig, {1, 0, 0});
  EXPECT_EQ(m.fulfilled("order"), 0U);
  carry(m, kSmall, {1.1, 0, 0});
  EXPECT_EQ(m.fulfilled("order"), 1U);
  EXPECT_FALSE(m.submitted("order", Eigen::Vector2d(2, 0))) << "no tray is there";
  EXPECT_TRUE(m.submitted("order", Eigen::Vector2d(1.05, 0)));
  EXPECT_FALSE(m.submitted("order", {})) << "only one was ordered";
  EXPECT_EQ(m.open("order"), 0U);
  const Measured result = m.result({});
  ASSERT_EQ(result.kits.size(), 1U);
  EXPECT_TRUE(result.kits[0].is_right());
  EXPECT_FALSE(result.kits[0].late);
  EXPECT_NEAR(result.values.at("kit_mean_s"), 0.6, 1e-9);
  EXPECT_NEAR(result.values.at("throughput_per_h"), 6000, 1e-6);
  EXPECT_EQ(result.values.at("parts_right"), 2);
}

TEST_F(MeasuresTest, ATraySubmittedAgainIsNoOtherOneNearby) {
  order_.count = 2;
  shape_.bodies.push_back(shape_.bodies[kKit]);
  shape_.bodies.back().name = "second kit";
  sample_.bodies.push_back(sample_.bodies[kKit]);
  put(sample_.bodies.size() - 1,
      sample_.bodies[kKit].pose.translation() + Eigen::Vector3d(0.1, 0, 0));
  Measures m = measures();
  step(m);
  m.announced("order");
  const Eigen::Vector2d at = sample_.bodies[kKit].pose.translation().head<2>();
  EXPECT_TRUE(m.submitted("order", at));
  EXPECT_FALSE(m.submitted("order", at));
  EXPECT_EQ(m.open("order"), 1U);
  EXPECT_TRUE(m.submitted("order", Eigen::Vector2d(at.x() + 0.1, at.y())));
}

TEST_F(MeasuresTest, WrongFlippedFaultyAndSurplusPartsAreNotRight) {
  order_.slots = {{"a", "big"}};
  Measures m = measures();
  step(m);
  m.announced("order");
  carry(m, kBig, {1, 0, 0});
  carry(m, kSmall, {1.1, 0, 0});  // nothing was ordered there
  sample_.bodies[kBig].pose.linear() =
      Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  step(m);
  EXPECT_TRUE(m.submitted("order", {}));
  const KitResult kit = m.result({}).kits.at(0);
  EXPECT_EQ(kit.right, 0U) << "upside down";
  EXPECT_EQ(kit.surplus, 1U);
  EXPECT_FALSE(kit.is_right());
}

TEST_F(MeasuresTest, AFaultyPartIsNotRight) {
  Measures m = measures();
  sample_.faults = {{.id = 1, .kind = "part-faulty", .target = "big_1", .begin_s = 0}};
  step(m);
  m.announced("order");
  carry(m, kBig, {1, 0, 0});
  carry(m, kSmall, {1.1, 0, 0});
  EXPECT_EQ(m.fulfilled("order"), 0U);
  EXPECT_TRUE(m.submitted("order", {}));
  EXPECT_EQ(m.result({}).kits.at(0).right, 1U);
}

TEST_F(MeasuresTest, ACancelledOrderIsNotWanted) {
  Measures m = measures();
  step(m);
  m.announced("order");
  m.cancelled("order");
  EXPECT_FALSE(m.submitted("order", {}));
  EXPECT_EQ(value(m, "kits_ordered"), 0);
  EXPECT_THROW(m.announced("nothing"), std::invalid_argument);
}

TEST_F(MeasuresTest, ContactIsOneCollision) {
  Measures m = measures();
  step(m);
  sample_.touches = {{"arm | table", false, 0.2, 0.21, 30}};
  step(m);
  sample_.touches = {{"arm | table", false, 0.2, 0.3, 42}};
  step(m);
  step(m);
  sample_.touches.push_back({"arm | table", false, 1.4, 1.4, 5});
  sample_.touches.push_back({"arm | other", true, 1.4, 1.5, 7});
  step(m);
  // Older ones are forgotten by the cell.
  sample_.touches.erase(sample_.touches.begin());
  step(m);
  const Measured result = m.result({});
  ASSERT_EQ(result.collisions.size(), 3U);
  EXPECT_EQ(result.collisions[0].max_n, 42);
  EXPECT_EQ(result.collisions[0].begin_s, 0.2);
  EXPECT_EQ(result.collisions[0].end_s, 0.3);
  EXPECT_TRUE(result.collisions[2].two_robots);
  EXPECT_EQ(result.values.at("collision_max_n"), 42);
}

TEST_F(MeasuresTest, RecoveryLastsUntilTheNextPart) {
  Measures m = measures();
  step(m);
  m.announced("order");
  carry(m, kBig, {1, 0, 0});
  sample_.faults = {
      {.id = 1, .kind = "robot-slow", .target = "arm", .begin_s = sample_.time_s + 0.1}};
  step(m);
  const double begin_s = sample_.time_s;
  step(m, 5);
  EXPECT_EQ(value(m, "faults_recovered"), 0);
  carry(m, kSmall, {1.1, 0, 0});
  const Measured result = m.result({});
  ASSERT_EQ(result.faults.size(), 1U);
  EXPECT_NEAR(*result.faults[0].recovery_s, sample_.time_s - begin_s, 1e-9);
  EXPECT_NEAR(result.values.at("recovery_max_s"), 5.3, 1e-9);
  EXPECT_EQ(result.values.at("faults_recovered"), 1);
}

KitResult right_kit() {
  return {
      .order = "o", .tray = "t", .submitted_s = 10, .tray_right = true, .ordered = 4, .right = 4};
}

TEST(Scores, FollowTheRulesForKits) {
  const scenario::Scoring rules;
  KitResult kit = right_kit();
  EXPECT_EQ(kit_score(kit, rules), 1 + 12 + 4);
  EXPECT_EQ(best_score(kit, rules), 17);
  kit.surplus = 2;
  EXPECT_EQ(kit_score(kit, rules), 15);
  kit.surplus = 0;
  kit.right = 3;
  EXPECT_EQ(kit_score(kit, rules), 1 + 9);
  kit.priority = 2;
  EXPECT_EQ(kit_score(kit, rules), 30);
  kit.at_destination = false;
  EXPECT_EQ(kit_score(kit, rules), 0);
  kit = right_kit();
  kit.tray_right = false;
  EXPECT_EQ(kit_score(kit, rules), -1 + 12 + 4);
  kit.right = 0;
  EXPECT_EQ(kit_score(kit, rules), 0) << "never below";
  kit = right_kit();
  kit.submitted_s.reset();
  EXPECT_EQ(kit_score(kit, rules), 0);
}

TEST(Scores, PenaltiesCountDurationAndBothRobots) {
  const scenario::Scoring rules;
  Measured measured;
  measured.values = {{"parts_lost", 2}, {"job_s", 20}};
  EXPECT_EQ(penalty(measured, rules), 50);
  measured.collisions = {{"a | b", true, 0, 4.9, 10}, {"a | table", false, 0, 10.1, 10}};
  EXPECT_EQ(penalty(measured, rules), 50 + 200 + 300);
}

TEST(Scores, EfficiencyAndAgilityAreRelativeToTheBaseline) {
  scenario::Scoring rules;
  rules.baseline_s = 50;
  rules.baseline_score = 34;
  Measured measured;
  measured.values = {{"parts_lost", 0}, {"job_s", 100}};
  measured.kits = {right_kit()};
  add_scores(measured, rules);
  EXPECT_EQ(measured.values.at("score"), 17);
  EXPECT_EQ(measured.values.at("score_share"), 1);
  EXPECT_EQ(measured.values.at("efficiency"), 0.5);
  EXPECT_NEAR(measured.values.at("agility"), 0.25, 1e-12);
}

TEST(Verdicts, KeepBoundsAndNameWhatBreaksThem) {
  Measured measured;
  measured.values = {{"kits_right", 3}, {"drops", 0}};
  const auto verdicts = judge(
      measured,
      {{"kits_right", {4, 4}}, {"drops", {std::nullopt, 0}}, {"agility", {0.5, std::nullopt}}});
  ASSERT_EQ(verdicts.size(), 3U);
  EXPECT_FALSE(verdicts[0].kept);
  EXPECT_EQ(text_of(verdicts[0]), "kits_right 3, expected 4");
  EXPECT_TRUE(verdicts[1].kept);
  EXPECT_EQ(text_of(verdicts[1]), "drops 0, expected at most 0");
  EXPECT_FALSE(verdicts[2].kept) << "nothing is known of it";
  EXPECT_EQ(text_of(verdicts[2]), "agility unknown, expected at least 0.5");
}

RunResult a_run() {
  RunResult run{.scenario = "job",
                .description = "a <job>",
                .controller = "kitting",
                .seed = 7,
                .end_reason = "all orders were submitted"};
  run.measured.kits = {right_kit()};
  run.measured.placements = {{1.5, "arm", "big_1", "kit/a", 2e-4, 0.01, true}};
  run.measured.faults = {{"robot-slow", "arm", 0.5, 2.0, 1.0, true}};
  run.measured.robots = {{.name = "arm", .moving = {{0.0, 1.0}}}};
  run.measured.values = {{"kits_right", 1}};
  run.measured.end_s = 12;
  run.events = {{0.5, "fault begins: robot-slow arm"}};
  run.verdicts = judge(run.measured, {{"kits_right", {1, 1}}});
  return run;
}

TEST(Report, IsTheSameForTheSameRun) {
  const auto json = report_json(a_run());
  EXPECT_EQ(json.dump(), report_json(a_run()).dump());
  EXPECT_EQ(json["measures"]["kits_right"], 1);
  EXPECT_TRUE(json["measures"]["drops"].is_null());
  EXPECT_EQ(json["as_expected"], true);
  EXPECT_EQ(json["faults"][0]["recovery_s"], 1.0);
}

TEST(Report, IsOnePageThatNeedsNothingElse) {
  const std::string page = report_page(a_run());
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_NE(page.find("a &lt;job&gt;"), std::string::npos) << "texts are no markup";
  for (const char* outside : {"http://", "https://", "src=", "href=", "<script"}) {
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  }
  const std::string table = report_table(a_run(), Paint());
  EXPECT_NE(table.find("kept     kits_right 1, expected 1"), std::string::npos) << table;
}

TEST_F(MeasuresTest, TheProgressOfAnOrderIsWhatIsRightInItsKits) {
  Measures m = measures();
  step(m);
  EXPECT_EQ(m.filled("order"), 0U) << "nothing is wanted yet";
  m.announced("order");
  carry(m, kBig, {1, 0, 0});
  EXPECT_EQ(m.filled("order"), 1U);
  carry(m, kSmall, {1.1, 0, 0});
  EXPECT_EQ(m.filled("order"), 2U);
  EXPECT_EQ(m.submitted_kits("order"), 0U);
  ASSERT_TRUE(m.submitted("order", {}));
  EXPECT_EQ(m.submitted_kits("order"), 1U);
  carry(m, kSmall, {6, 0, 0});
  EXPECT_EQ(m.filled("order"), 2U) << "as it was submitted";
}

}  // namespace
}  // namespace aprsim::client
