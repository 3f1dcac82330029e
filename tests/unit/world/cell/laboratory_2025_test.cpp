// The laboratory of 2025 as its controllers find it: everything at rest, every place in reach.

#include <algorithm>
#include <map>
#include <memory>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"
#include "world/robot/kinematics/choice/make_inverse_kinematics.hpp"
#include "world/robot/model/arm_model.hpp"

namespace aprsim::world {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kTable = 0.839;  ///< top of the optical table over the floor [m]

TEST(Laboratory2025, NothingMovesAfterTwoSeconds) {
  test::CellScript cell(test::load_scene("aprs_2025"));
  const api::Snapshot at_start = cell.now;
  cell.advance(2000);
  const api::Snapshot settled = cell.now;
  cell.advance(1000);
  const auto& bodies = cell.world.description()->bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Pose &before = at_start.bodies[i].X_WB, &then = settled.bodies[i].X_WB,
               &now = cell.now.bodies[i].X_WB;
    EXPECT_LT((now.p - then.p).norm(), 1e-9) << bodies[i].name;
    EXPECT_LT((then.p - before.p).norm(), 2e-4) << bodies[i].name;
    EXPECT_LT(cell.now.bodies[i].v_W.norm(), 1e-6) << bodies[i].name;
  }
}

TEST(Laboratory2025, EveryGearStaysInItsSlot) {
  const auto scene = test::load_scene("aprs_2025");
  test::CellScript cell(scene);
  cell.advance(2000);
  int seated = 0;
  for (const auto& tray : scene->trays) {
    for (const auto& [slot, gear] : tray.gears) {
      const Isometry3d X_SG = cell.X_WS(tray.name, slot).inverse() * cell.X_WB(gear);
      EXPECT_LT(X_SG.translation().head<2>().norm(), 4e-4) << gear;
      EXPECT_NEAR(X_SG.translation().z(), 0, 1e-4) << gear;
      EXPECT_GT(X_SG(2, 2), 1 - 1e-6) << gear;
      ++seated;
    }
  }
  EXPECT_EQ(seated, 17);
}

TEST(Laboratory2025, TheSameCommandsGiveTheSameBits) {
  const auto run = [] {
    test::CellScript cell(test::load_scene("aprs_2025"));
    cell.world.apply(1, api::ConveyorCommand{.run = true, .forward = true, .speed_m_s = 0.15});
    cell.world.apply(2, api::RobotCommand{0, api::InitRobot{}});
    cell.world.apply(3, api::RobotCommand{0, api::MoveJoints{{{.joint = 0, .position_rad = 1.5}}}});
    cell.advance(3000);
    return cell.now;
  };
  const api::Snapshot a = run(), b = run();
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    EXPECT_EQ(a.bodies[i].X_WB.p, b.bodies[i].X_WB.p);
    EXPECT_EQ(a.bodies[i].X_WB.q.coeffs(), b.bodies[i].X_WB.q.coeffs());
  }
  EXPECT_EQ(a.robots[0].X_WT.p, b.robots[0].X_WT.p);
}

TEST(Laboratory2025, TheDescriptionHasTheOutlines) {
  const World world(test::load_scene("aprs_2025"), 1);
  std::map<std::string, std::size_t> corners;
  for (const auto& body : world.description()->bodies) {
    if (body.kind == api::BodyKind::kGear) continue;
    corners[body.type] = body.outline.size();
    EXPECT_EQ(body.label_size_m, 0.04);
    EXPECT_EQ(body.label_depth_m, 0.001);
    for (const auto& corner : body.outline) {
      EXPECT_TRUE((corner.array() >= body.box_min.head<2>().array()).all());
      EXPECT_TRUE((corner.array() <= body.box_max.head<2>().array()).all());
    }
  }
  EXPECT_EQ(corners, (std::map<std::string, std::size_t>{{"sku_kit_m2l1_vessel", 21},
                                                         {"sku_kit_s2l2_vessel", 22},
                                                         {"sku_large_gear_vessel", 16},
                                                         {"sku_medium_gear_vessel", 20},
                                                         {"sku_small_gear_vessel", 20}}));
}

class LaboratoryReach : public testing::Test {
 protected:
  /// The tool point at p, straight down, the fingers closing along world y, as the controllers
  /// command it: rpy 0, pi, 0.
  static Isometry3d tool_down(const Vector3d& p_W) {
    return Eigen::Translation3d(p_W) * Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitY());
  }

  bool reaches(const scene::Robot& robot, const Vector3d& p_W) {
    const auto model = robot::load_arm_model(robot.model_file);
    const auto ik = robot::make_inverse_kinematics(*model);
    const Isometry3d X_BF =
        robot.X_WB.isometry().inverse() * tool_down(p_W) * robot.X_FT.isometry().inverse();
    const auto count = static_cast<Eigen::Index>(robot.home_rad.size());
    const robot::JointVector home = Eigen::Map<const Eigen::VectorXd>(robot.home_rad.data(), count);
    const auto elbow = (*ik)->choose_elbow(X_BF, home);
    return elbow && (*ik)->nearest(X_BF, home, *elbow).has_value();
  }

  std::shared_ptr<const scene::Scene> scene_ = test::load_scene("aprs_2025");
};

TEST_F(LaboratoryReach, EachRobotReachesEverySlotOfItsTable) {
  std::map<std::string, int> slots;
  for (const auto& tray : scene_->trays) {
    for (const std::string& name : tray.reachable_by) {
      const auto robot = std::find_if(scene_->robots.begin(), scene_->robots.end(),
                                      [&name](const auto& r) { return r.name == name; });
      for (const auto& slot : scene_->tray_types.at(tray.type).slots) {
        Vector3d p = tray.X_WP.isometry() * Vector3d(slot.xy.x(), slot.xy.y(), 0);
        // Approach, pick of the Fanuc and of the Motoman, place: above the table.
        for (const double height : {0.131, 0.031, 0.036, 0.041}) {
          p.z() = kTable + height;
          EXPECT_TRUE(reaches(*robot, p))
              << name << ' ' << tray.name << ' ' << slot.name << ' ' << height;
        }
        ++slots[name];
      }
    }
  }
  EXPECT_EQ(slots["fanuc"], 12);
  EXPECT_EQ(slots["motoman"], 10);
}

TEST_F(LaboratoryReach, EachRobotReachesItsPartOfTheBelt) {
  const double belt = scene_->conveyor->X_WC.p.z() - kTable;
  EXPECT_NEAR(belt, 0.062, 1e-12);
  for (const auto& robot : scene_->robots) {
    const double x = robot.X_WB.p.x();
    for (const double along : {-0.2, 0.0, 0.2}) {
      for (const double y : {-0.25, -0.35}) {
        for (const double height : {0.031, 0.131}) {
          EXPECT_TRUE(reaches(robot, {x + along, y, kTable + belt + height}))
              << robot.name << ' ' << along << ' ' << y << ' ' << height;
        }
      }
    }
  }
}

TEST_F(LaboratoryReach, TheTeachingTableIsOutOfReach) {
  for (const auto& tray : scene_->trays) {
    if (tray.name.find("teach_") != 0) continue;
    for (const auto& robot : scene_->robots) {
      EXPECT_FALSE(reaches(robot, tray.X_WP.p + Vector3d(0, 0, 0.016))) << tray.name;
    }
  }
}

}  // namespace
}  // namespace aprsim::world
