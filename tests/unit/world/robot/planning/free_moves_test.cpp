#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/controller/controller_rig.hpp"
#include "world/robot/planning/motion_planner.hpp"

namespace aprsim::robot {
namespace {

constexpr double kTravel_m_s = 0.4;
const double kTurn_rad_s = radians(30);

/// Free moves of an arm with the APRS framework's limits, 400 mm/s and 30 degrees/s.
class FreeMoves : public testing::TestWithParam<const char*> {
 protected:
  FreeMoves()
      : setup_(rig_setup(GetParam())),
        planner_({setup_.model, setup_.ik, Eigen::Isometry3d::Identity(), setup_.payload,
                  setup_.gravity_B}),
        limits_({1.5, 5, 6, 30}) {
    limits_.set({api::MotionLimit::kTransSpeed, false, kTravel_m_s});
    limits_.set({api::MotionLimit::kRotSpeed, false, kTurn_rad_s});
  }

  struct Run {
    double seconds = 0;
    double travel_m = 0, turn_rad = 0;  ///< from end to end
    double joints_s = 0;                ///< that the slowest joint needs at full speed
    double way_m = 0, speed_m_s = 0, turn_rad_s = 0;  ///< of the tool on the way
    JointVector end;
    [[nodiscard]] double least() const {
      return std::max({travel_m / kTravel_m_s, turn_rad / kTurn_rad_s, joints_s});
    }
  };

  [[nodiscard]] bool fanuc() const { return setup_.model.dof() == 6; }
  Eigen::Isometry3d tool(const JointVector& q) const { return planner_.tool_pose(q, setup_.X_FT); }

  std::optional<Run> run(const JointVector& start, const Eigen::Isometry3d& X_BT) const {
    MotionPlan plan;
    const api::MoveTo move{Pose::from(X_BT), false};
    if (!planner_.plan(move, {start, setup_.X_FT}, limits_, plan)) return std::nullopt;
    Run out;
    const JointMotion motion = *plan[0].joint();
    out.seconds = motion.duration();
    out.end = plan.end();
    const Eigen::Isometry3d from = tool(start);
    out.travel_m = (X_BT.translation() - from.translation()).norm();
    out.turn_rad = Eigen::AngleAxisd(from.linear().transpose() * X_BT.linear()).angle();
    out.joints_s =
        ((out.end - start).cwiseAbs().array() / planner_.joint_limits().speed.array()).maxCoeff();
    constexpr int kSamples = 400;
    Eigen::Isometry3d last = from;
    for (int i = 1; i <= kSamples; ++i) {
      JointVector q;
      motion.at(out.seconds * i / kSamples, q);
      const Eigen::Isometry3d X = tool(q);
      const double dt = out.seconds / kSamples;
      const double way = (X.translation() - last.translation()).norm();
      out.way_m += way;
      out.speed_m_s = std::max(out.speed_m_s, way / dt);
      out.turn_rad_s = std::max(
          out.turn_rad_s, Eigen::AngleAxisd(last.linear().transpose() * X.linear()).angle() / dt);
      last = X;
    }
    return out;
  }

  /// Tool down over the work area, turned about the vertical.
  Eigen::Isometry3d over_table(double radius, double angle, double z, double yaw) const {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translation() = Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), z);
    X.linear() =
        Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0))
            .toRotationMatrix();
    return X;
  }

  ControllerSetup setup_;
  MotionPlanner planner_;
  ToolLimitSettings limits_;
};
INSTANTIATE_TEST_SUITE_P(Arms, FreeMoves, testing::Values("fanuc", "motoman"),
                         [](const auto& arm) { return std::string(arm.param); });

/// Between random poses over the table, one after the other, so that the wrist winds up, too.
TEST_P(FreeMoves, TakeNoLongerThanTravelTurnAndJointsNeed) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  JointVector q = setup_.q_home;
  int planned = 0;
  for (int i = 0; i < 400; ++i) {
    const double radius = fanuc() ? 0.45 + 0.15 * unit(engine) : 0.6 + 0.2 * unit(engine);
    const Eigen::Isometry3d to =
        over_table(radius, 1.2 * unit(engine), (fanuc() ? 0.15 : 0.25) + 0.1 * unit(engine),
                   std::numbers::pi * unit(engine));
    const auto moved = run(q, to);
    if (!moved) continue;
    ++planned;
    // The tool's point keeps its speed on an arc, which is longer than the chord and not all of it
    // at full speed; speeding up and slowing down takes 0.6 s at most.
    EXPECT_LE(moved->seconds, std::max(moved->least(), 1.9 * moved->way_m / kTravel_m_s) + 0.6)
        << i << " least " << moved->least();
    EXPECT_GE(moved->seconds, moved->least());
    EXPECT_LE(moved->speed_m_s, 1.01 * kTravel_m_s) << i;
    EXPECT_LE(moved->turn_rad_s, 6.06) << i;
    q = moved->end;
  }
  EXPECT_GE(planned, 350);
}

/// The pose above the parts from where a wound-up wrist has to unwind: the turn from end to end
/// counts, not that of the unwinding.
TEST_P(FreeMoves, AnUnwindingWristTakesNoLonger) {
  JointVector q(setup_.model.dof());
  const double last = fanuc() ? radians(300) : radians(170);
  if (fanuc()) {
    q << 0.2, 0.4, -0.4, 0.0, -1.0, last;
  } else {
    q << 0.2, 0.5, 0.1, -1.4, 0.0, -1.2, last;
  }
  const Eigen::Isometry3d from = tool(q);
  Eigen::Isometry3d to = from;
  to.linear() =
      from.linear() * Eigen::AngleAxisd(radians(-80), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  auto moved = run(q, to);
  ASSERT_TRUE(moved);
  if ((moved->end - q).cwiseAbs().maxCoeff() < radians(100)) {
    to.linear() =
        from.linear() * Eigen::AngleAxisd(radians(80), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    moved = run(q, to);
    ASSERT_TRUE(moved);
  }
  EXPECT_NEAR(moved->turn_rad, radians(80), 1e-9);
  EXPECT_LE(moved->seconds, moved->least() + 0.8);
}

/// No more turns than needed: the last joint goes by the nearest multiple of a full turn.
TEST_P(FreeMoves, TheWristTurnsTheShortestWay) {
  JointVector q(setup_.model.dof());
  if (fanuc()) {
    q << 0.2, 0.4, -0.4, 0.0, -1.0, radians(170);
  } else {
    q << 0.2, 0.5, 0.1, -1.4, 0.0, -1.2, 0.0;
  }
  const Eigen::Isometry3d from = tool(q);
  for (const double turn : {20.0, 50.0, -60.0, -120.0, -170.0}) {
    Eigen::Isometry3d to = from;
    to.linear() = from.linear() *
                  Eigen::AngleAxisd(radians(turn), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const auto moved = run(q, to);
    ASSERT_TRUE(moved) << turn;
    EXPECT_LE((moved->end - q).cwiseAbs().maxCoeff(), radians(std::abs(turn)) + 1e-6) << turn;
    EXPECT_LE(moved->seconds, std::abs(turn) / 30 + 0.8) << turn;
  }
}

}  // namespace
}  // namespace aprsim::robot
