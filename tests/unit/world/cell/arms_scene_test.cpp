// The scene of four arms: every arm moves on straight lines, refuses what it cannot reach, and
// carries a gear.

#include <gtest/gtest.h>

#include "tests/support/pick_place.hpp"

namespace aprsim::test {
namespace {

constexpr int kScara = 3;

class ArmsScene : public testing::TestWithParam<int> {
 protected:
  CellScript cell_{load_scene("arms")};
  int robot_ = GetParam();

  [[nodiscard]] const api::RobotSnapshot& robot() const {
    return cell_.now.robots[static_cast<std::size_t>(robot_)];
  }
  void move_by(const Eigen::Vector3d& way) {
    Pose target = robot().X_RT;
    target.p += way;
    cell_.act(robot_, api::MoveTo{target, true});
    EXPECT_LT((robot().X_RT.p - target.p).norm(), 1e-4);
    EXPECT_LT(robot().X_RT.q.angularDistance(target.q), 1e-3);
  }
};

TEST_P(ArmsScene, MovesOnStraightLinesAndBack) {
  cell_.act(robot_, api::InitRobot{});
  const Pose home = robot().X_RT;
  EXPECT_LT((home.q * Eigen::Vector3d::UnitZ()).z(), -1 + 1e-6);
  for (const Eigen::Vector3d& way :
       {Eigen::Vector3d(0, 0, -0.02), Eigen::Vector3d(0.03, 0.02, 0.01),
        Eigen::Vector3d(-0.03, -0.02, 0.01)}) {
    move_by(way);
  }
  EXPECT_LT((robot().X_RT.p - home.p).norm(), 2e-4);
}

TEST_P(ArmsScene, TurnsItsToolAboutTheVertical) {
  cell_.act(robot_, api::InitRobot{});
  Pose target = robot().X_RT;
  target.q = Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ())) * target.q;
  cell_.act(robot_, api::MoveTo{target, false});
  EXPECT_LT(robot().X_RT.q.angularDistance(target.q), 1e-3);
}

TEST_P(ArmsScene, RefusesATiltOnlyWhereAxesAreMissing) {
  cell_.act(robot_, api::InitRobot{});
  Pose target = robot().X_RT;
  target.q = Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX())) * target.q;
  if (robot_ != kScara) return cell_.act(robot_, api::MoveTo{target, false});
  try {
    cell_.act(robot_, api::MoveTo{target, false});
    FAIL() << "a tilted pose has been reached by four axes";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("tilted by 5.730 deg"), std::string::npos)
        << error.what();
  }
}

TEST_P(ArmsScene, CarriesAGear) {
  const std::string name = cell_.world.description()->robots[static_cast<std::size_t>(robot_)].name;
  const std::string gear = "part_medium_gear_" + std::to_string(2 * robot_ + 1);
  const PickPlaceReport report = pick_and_place(cell_, robot_, gear, name + "_gears", "slot_3", 0);
  EXPECT_GT(report.lift_m, 0.05);
  EXPECT_LT(report.place_error_m, 2e-3);
  EXPECT_LT(report.max_penetration_m, 5e-4);
}

INSTANTIATE_TEST_SUITE_P(Robots, ArmsScene, testing::Range(0, 4), [](const auto& which) {
  return std::string(
      std::array{"ur5e", "irb120", "panda", "scara"}[static_cast<std::size_t>(which.param)]);
});

}  // namespace
}  // namespace aprsim::test
