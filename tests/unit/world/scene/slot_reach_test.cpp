#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "world/robot/kinematics/choice/make_inverse_kinematics.hpp"
#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/model/arm_model.hpp"
#include "world/scene/checks/scene_solids.hpp"
#include "world/scene/model/part_shapes.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::scene {
namespace {

constexpr double kTipAboveDisc = 3.5e-3, kApproach = 0.06;
constexpr int kYaws = 8;

using Eigen::Isometry3d;
using Eigen::Vector3d;

struct Arm {
  const Robot* robot = nullptr;
  robot::ArmModel model;
  std::unique_ptr<robot::InverseKinematics> ik;
  robot::JointVector home;

  std::optional<robot::JointVector> joints_at(const Isometry3d& X_WT) const {
    const Isometry3d X_BF =
        robot->X_WB.isometry().inverse() * X_WT * robot->X_FT.isometry().inverse();
    const auto elbow = ik->choose_elbow(X_BF, home);
    if (!elbow) return std::nullopt;
    const auto q = ik->nearest(X_BF, home, *elbow);
    return q ? std::optional(*q) : std::nullopt;
  }
};

Arm make_arm(const Robot& robot) {
  auto model = robot::load_arm_model(robot.model_file);
  EXPECT_TRUE(model.has_value()) << model.error().message;
  auto ik = robot::make_inverse_kinematics(*model);
  EXPECT_TRUE(ik.has_value()) << ik.error().message;
  EXPECT_EQ(static_cast<std::size_t>(model->dof()), robot.home_rad.size());
  const auto count = static_cast<Eigen::Index>(robot.home_rad.size());
  return {&robot, std::move(*model), std::move(*ik),
          Eigen::Map<const Eigen::VectorXd>(robot.home_rad.data(), count)};
}

/// A solid that holds the shape: round ends become flat ones further out.
Solid around(const robot::LinkShape& shape, const Isometry3d& X_WL) {
  const Isometry3d X_WS = X_WL * shape.X_LS;
  if (const auto* box = std::get_if<robot::BoxShape>(&shape.shape)) {
    return {BoxSolid{box->size / 2}, X_WS};
  }
  double radius = 0, half = 0;
  if (const auto* capsule = std::get_if<robot::CapsuleShape>(&shape.shape)) {
    radius = capsule->radius_m;
    half = capsule->length_m / 2 + radius;
  } else if (const auto* cylinder = std::get_if<robot::CylinderShape>(&shape.shape)) {
    radius = cylinder->radius_m;
    half = cylinder->length_m / 2;
  } else {
    radius = half = std::get<robot::SphereShape>(shape.shape).radius_m;
  }
  return {FrustumSolid{half, radius, radius}, X_WS};
}

/// Tables, belt and trays: what the arm must not touch while it picks.
std::vector<Solid> obstacles_of(const Scene& scene) {
  std::vector<Solid> result;
  for (const StaticBox& box : scene.fixed) result.push_back(solid_of(box));
  if (scene.conveyor) result.push_back(solid_of(*scene.conveyor));
  for (const TrayInstance& tray : scene.trays) {
    result.push_back(solid_of(scene.tray_types.at(tray.type), tray.X_WP));
  }
  return result;
}

/// The arm from its second moving link on, and the gripper's palm. The base stands on its table.
std::vector<Solid> moving_solids(const Arm& arm, const robot::JointVector& q) {
  std::vector<Isometry3d> X_BL(arm.model.links.size());
  robot::link_poses(arm.model, q, X_BL);
  const Isometry3d X_WB = arm.robot->X_WB.isometry();
  std::vector<Solid> result;
  for (std::size_t i = 2; i < arm.model.links.size(); ++i) {
    for (const robot::LinkShape& shape : arm.model.links[i].collision) {
      result.push_back(around(shape, X_WB * X_BL[i]));
    }
  }
  const Block palm = palm_of(arm.robot->gripper);
  result.push_back({BoxSolid{palm.size / 2}, X_WB * X_BL.back() * arm.robot->X_FT.isometry() *
                                                 Eigen::Translation3d(palm.centre)});
  return result;
}

bool clear(const std::vector<Solid>& moving, const std::vector<Solid>& obstacles) {
  for (const Solid& part : moving) {
    for (const Solid& obstacle : obstacles) {
      if (overlap_depth(part, obstacle) > 0) return false;
    }
  }
  return true;
}

/// The number of yaws, of kYaws, with which the tool reaches down to the peg and comes from above,
/// with the arm clear of the obstacles.
int yaws_reached(const Arm& arm, const std::vector<Solid>& obstacles, const GearType& gear,
                 const Vector3d& p_WS) {
  int reached = 0;
  const Vector3d pick = p_WS + Vector3d(0, 0, gear.disc_height_m + kTipAboveDisc);
  for (int i = 0; i < kYaws; ++i) {
    const Isometry3d X_WT = Eigen::Translation3d(pick) *
                            Eigen::AngleAxisd(2 * std::numbers::pi * i / kYaws, Vector3d::UnitZ()) *
                            Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX());
    bool good = true;
    for (const double height : {0.0, kApproach}) {
      const auto q = arm.joints_at(Eigen::Translation3d(0, 0, height) * X_WT);
      good = good && q && clear(moving_solids(arm, *q), obstacles);
    }
    if (good) ++reached;
  }
  return reached;
}

class SlotReach : public testing::TestWithParam<const char*> {};

TEST_P(SlotReach, EverySlotIsReachedToolDownByTheRobotsThatItsTrayNames) {
  const auto scene = load_scene(GetParam(), default_data_paths());
  ASSERT_TRUE(scene.has_value()) << scene.error().message;
  std::map<std::string, Arm> arms;
  for (const Robot& robot : scene->robots) arms.emplace(robot.name, make_arm(robot));
  const std::vector<Solid> obstacles = obstacles_of(*scene);
  std::map<std::string, int> slots;
  for (const TrayInstance& tray : scene->trays) {
    const TrayType& type = scene->tray_types.at(tray.type);
    for (const std::string& name : tray.reachable_by) {
      for (const Slot& slot : type.slots) {
        const Eigen::Vector3d p_WS =
            tray.X_WP.isometry() * Eigen::Vector3d(slot.xy.x(), slot.xy.y(), 0);
        const int yaws =
            yaws_reached(arms.at(name), obstacles, scene->gear_types.at(slot.gear_type), p_WS);
        // Half of the yaws at least, so that a controller has a choice.
        EXPECT_GE(yaws, kYaws / 2) << name << ", " << tray.name << ", " << slot.name;
        ++slots[name];
      }
    }
  }
  for (const auto& [name, arm] : arms) {
    EXPECT_TRUE(clear(moving_solids(arm, arm.home), obstacles)) << name << " at home";
  }
  EXPECT_GE(slots["fanuc"], 12);
  EXPECT_GE(slots["motoman"], 10);
}

TEST(SlotReachCheck, AnArmThroughItsTableIsNotClear) {
  const auto scene = load_scene("aprs", default_data_paths());
  ASSERT_TRUE(scene.has_value()) << scene.error().message;
  const std::vector<Solid> obstacles = obstacles_of(*scene);
  for (const Robot& robot : scene->robots) {
    const Arm arm = make_arm(robot);
    // Straight down before the base, 10 cm below where it stands.
    const Isometry3d X_WT = robot.X_WB.isometry() * Eigen::Translation3d(0.5, 0, -0.1) *
                            Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX());
    const auto q = arm.joints_at(X_WT);
    ASSERT_TRUE(q) << robot.name;
    EXPECT_GE(moving_solids(arm, *q).size(), 6u) << robot.name;
    EXPECT_FALSE(clear(moving_solids(arm, *q), obstacles)) << robot.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Cells, SlotReach,
                         testing::Values("aprs", "aprs_2024", "aprs_2025", "aprs_lab"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace aprsim::scene
