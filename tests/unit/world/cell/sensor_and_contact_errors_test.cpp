// Delay of guards, relaxation of the gripper's mount and errors of the force sensor, in the default
// cell: the Fanuc comes down on a gear with closed fingers.

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/pick_place.hpp"
#include "world/cell/state_bytes.hpp"
#include "world/scene/data_paths.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::test {
namespace {

const char* const kPressedGear = "part_large_gear_1";

std::shared_ptr<const scene::Scene> changed_cell(const std::string& robot,
                                                 const std::string& gripper) {
  const std::string text = "base: aprs\nrobots:\n- {name: fanuc" + robot +
                           "}\nrobot_types: {fanuc_lrmate200id: {gripper: {" + gripper + "}}}\n";
  auto scene = scene::read_scene(text, "changed.yaml", scene::default_data_paths());
  if (!scene) throw std::runtime_error(scene.error().message);
  return std::make_shared<const scene::Scene>(*std::move(scene));
}

class Press {
 public:
  explicit Press(const std::string& robot,
                 const std::string& gripper = "palm_relaxation: {share: 0, time_s: 1}")
      : cell(changed_cell(robot, gripper)) {
    const auto& fanuc = cell.world.description()->robots[0];
    X_RW_ = (fanuc.X_WB.isometry() * fanuc.X_BR.isometry()).inverse();
    const std::size_t gear = cell.body(kPressedGear);
    peg_W_ = cell.X_WB(kPressedGear) *
             Eigen::Vector3d(0, 0, cell.world.description()->bodies[gear].peg_top_m);
    cell.act(0, api::InitRobot{});
    cell.act(0, api::SetGripper{0});
    move(0.02);
    cell.act(0, api::SetMotionLimit{api::MotionLimit::kTransSpeed, false, 0.02});
  }

  void move(double height_m, std::vector<api::Guard> guards = {}) {
    api::MoveTo move;
    move.X_RT = Pose::from(X_RW_ * tool_down(peg_W_ + Eigen::Vector3d(0, 0, height_m), 0));
    move.straight = height_m < 0.01;
    cell.act(0, move, 30, std::move(guards));
  }
  /// Down until a force is felt.
  void touch() {
    api::Guard guard;
    guard.signal = {api::SignalKind::kForceR, 2};
    guard.limit = api::GuardLimit::kIncreased;
    guard.value = 2;
    guard.recheck = SimTime::zero();
    guard.label = "test";
    move(-0.02, {guard});
    settle();
  }
  void settle() {
    for (int i = 0; i < 2000 && robot().moving; ++i) cell.advance();
  }
  [[nodiscard]] double force_n() const { return robot().force_T_R.z(); }
  [[nodiscard]] const api::RobotSnapshot& robot() const { return cell.now.robots[0]; }
  [[nodiscard]] double height_m() const { return robot().X_WT.p.z() - peg_W_.z(); }

  CellScript cell;

 private:
  Eigen::Isometry3d X_RW_;
  Eigen::Vector3d peg_W_;
};

TEST(GuardDelay, LetsTheRobotGoOnForItsTime) {
  Press prompt(""), late(", guard_delay_s: 0.04");
  prompt.touch();
  late.touch();
  // 40 ms at 20 mm/s.
  EXPECT_NEAR(prompt.height_m() - late.height_m(), 0.8e-3, 0.05e-3);
  const SimTime longer = late.robot().guards.stop_time - prompt.robot().guards.stop_time;
  EXPECT_NEAR(seconds(longer), 0.04, 0.002);
  EXPECT_EQ(late.robot().action.state, api::ActionState::kDone);
  EXPECT_GT(late.force_n(), prompt.force_n() + 2);
  EXPECT_FALSE(late.robot().protective_stop);
}

TEST(PalmRelaxation, TakesItsShareOfAHeldForceWithItsTime) {
  Press stiff(""), soft("", "palm_relaxation: {share: 0.15, time_s: 2}");
  stiff.touch();
  soft.touch();
  // The arm yields a little and returns, in both alike.
  EXPECT_NEAR(soft.force_n() / stiff.force_n(), 1, 0.01);
  stiff.cell.advance(2000);
  soft.cell.advance(2000);
  EXPECT_NEAR(soft.force_n() / stiff.force_n(), 1 - 0.15 * (1 - std::exp(-1)), 0.015);
  stiff.cell.advance(10000);
  soft.cell.advance(10000);
  EXPECT_NEAR(soft.force_n() / stiff.force_n(), 0.85, 0.01);
  // Without load it recovers.
  soft.move(0.02);
  soft.cell.advance(30000);
  EXPECT_LT(soft.robot().gripper.palm_deflection_m, 1e-6);
}

TEST(PalmRelaxation, GoesOnBitForBitFromASavedState) {
  Press soft("", "palm_relaxation: {share: 0.15, time_s: 2}");
  soft.touch();
  soft.cell.advance(500);
  const auto saved = soft.cell.world.save();
  soft.cell.advance(300);
  const double force = soft.force_n();
  const auto hash = soft.cell.world.state_hash();
  soft.cell.world.restore(saved);
  soft.cell.advance(300);
  EXPECT_EQ(soft.force_n(), force);
  EXPECT_EQ(soft.cell.world.state_hash(), hash);
}

TEST(ForceSensorErrors, AreReadAndChangeNoMotion) {
  Press exact(""), biased(", force_sensor: {bias_n: [0, 0, -35], drift_n_s: [0, 0, 0.01]}");
  EXPECT_NEAR(exact.force_n(), 0, 1e-6);
  // The tool's z points down.
  EXPECT_NEAR(biased.force_n(), 35 - 0.01 * seconds(biased.cell.now.time), 1e-4);
  exact.touch();
  biased.touch();
  EXPECT_NEAR(exact.height_m(), biased.height_m(), 1e-5);
}

}  // namespace
}  // namespace aprsim::test
