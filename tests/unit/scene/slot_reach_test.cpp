#include <map>
#include <memory>
#include <numbers>

#include <gtest/gtest.h>

#include "world/robot/arm_model.hpp"
#include "world/robot/inverse_kinematics.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::scene {
namespace {

constexpr double kTipAboveDisc = 3.5e-3, kApproach = 0.06;
constexpr int kYaws = 8;

struct Arm {
  const Robot* robot = nullptr;
  std::unique_ptr<robot::InverseKinematics> ik;
  robot::JointVector home;

  bool reaches(const Eigen::Isometry3d& X_WT) const {
    const Eigen::Isometry3d X_BF =
        robot->X_WB.isometry().inverse() * X_WT * robot->X_FT.isometry().inverse();
    const auto elbow = ik->choose_elbow(X_BF, home);
    return elbow && ik->nearest(X_BF, home, *elbow);
  }
};

Arm make_arm(const Robot& robot) {
  auto model = robot::load_arm_model(robot.model_file);
  EXPECT_TRUE(model.has_value()) << model.error().message;
  auto ik = robot::make_inverse_kinematics(*model);
  EXPECT_TRUE(ik.has_value()) << ik.error().message;
  EXPECT_EQ(static_cast<std::size_t>(model->dof()), robot.home_rad.size());
  const auto count = static_cast<Eigen::Index>(robot.home_rad.size());
  return {&robot, std::move(*ik), Eigen::Map<const Eigen::VectorXd>(robot.home_rad.data(), count)};
}

/// The number of yaws, of kYaws, with which the tool reaches down to the peg and comes from above.
int yaws_reached(const Arm& arm, const GearType& gear, const Eigen::Vector3d& p_WS) {
  int reached = 0;
  const Eigen::Vector3d pick = p_WS + Eigen::Vector3d(0, 0, gear.disc_height_m + kTipAboveDisc);
  for (int i = 0; i < kYaws; ++i) {
    const Eigen::Isometry3d X_WT =
        Eigen::Translation3d(pick) *
        Eigen::AngleAxisd(2 * std::numbers::pi * i / kYaws, Eigen::Vector3d::UnitZ()) *
        Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX());
    if (arm.reaches(X_WT) && arm.reaches(Eigen::Translation3d(0, 0, kApproach) * X_WT)) ++reached;
  }
  return reached;
}

class SlotReach : public testing::TestWithParam<const char*> {};

TEST_P(SlotReach, EverySlotIsReachedToolDownByTheRobotsThatItsTrayNames) {
  const auto scene = load_scene(GetParam(), default_data_paths());
  ASSERT_TRUE(scene.has_value()) << scene.error().message;
  std::map<std::string, Arm> arms;
  for (const Robot& robot : scene->robots) arms.emplace(robot.name, make_arm(robot));
  std::map<std::string, int> slots;
  for (const TrayInstance& tray : scene->trays) {
    const TrayType& type = scene->tray_types.at(tray.type);
    for (const std::string& name : tray.reachable_by) {
      for (const Slot& slot : type.slots) {
        const Eigen::Vector3d p_WS =
            tray.X_WP.isometry() * Eigen::Vector3d(slot.xy.x(), slot.xy.y(), 0);
        const int yaws = yaws_reached(arms.at(name), scene->gear_types.at(slot.gear_type), p_WS);
        // Half of the yaws at least, so that a controller has a choice.
        EXPECT_GE(yaws, kYaws / 2) << name << ", " << tray.name << ", " << slot.name;
        ++slots[name];
      }
    }
  }
  EXPECT_GE(slots["fanuc"], 12);
  EXPECT_GE(slots["motoman"], 12);
}

INSTANTIATE_TEST_SUITE_P(Cells, SlotReach, testing::Values("aprs", "aprs_2024"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace aprsim::scene
