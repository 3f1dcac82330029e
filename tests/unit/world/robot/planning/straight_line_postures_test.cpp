#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/case_count.hpp"
#include "tests/unit/world/robot/controller/controller_rig.hpp"
#include "world/robot/kinematics/pose_projection.hpp"
#include "world/robot/planning/motion_planner.hpp"

namespace aprsim::robot {
namespace {

constexpr double kStep_s = 1e-3;
constexpr int kLines = 500;
constexpr double kLeastDexterity = 2e-3;

/// A straight move of an arm, run from its plan.
struct LineRun {
  bool planned = false;
  std::string reason;
  double off_m = 0, off_rad = 0;  ///< from the line
  double speed = 0, accel = 0;    ///< shares of the joints' limits
  double beyond_rad = 0;          ///< joint ranges
  double seconds = 0;
  Eigen::Isometry3d end;
};

class LineArm {
 public:
  explicit LineArm(const std::string& name)
      : setup_(rig_setup(name)),
        planner_({setup_.model, setup_.ik, setup_.X_BR, setup_.payload, setup_.gravity_B}),
        settings_({setup_.max_trans_speed_m_s, setup_.max_trans_accel_m_s2,
                   setup_.max_rot_speed_rad_s, setup_.max_rot_accel_rad_s2}) {}

  const ArmModel& model() const { return setup_.model; }
  const InverseKinematics& ik() const { return *setup_.ik; }
  const JointVector& home() const { return setup_.q_home; }
  Eigen::Isometry3d tool(const JointVector& q) const { return planner_.tool_pose(q, setup_.X_FT); }
  Eigen::Isometry3d flange(const Eigen::Isometry3d& X_BT) const {
    return X_BT * setup_.X_FT.inverse();
  }

  LineRun run(const JointVector& start, const Eigen::Isometry3d& X_BT) const {
    LineRun out;
    const api::MoveTo move{Pose::from(setup_.X_BR.inverse() * X_BT), true};
    auto plan = std::make_shared<MotionPlan>();
    if (const auto ok = planner_.plan(move, {start, setup_.X_FT}, settings_, *plan); !ok) {
      out.reason = ok.error().message;
      return out;
    }
    out.planned = true;
    const Eigen::Isometry3d from = tool(start);
    MotionSequence motion{std::shared_ptr<const MotionPlan>(plan)};
    JointVector q = start, last = start, second_last = start;
    const JointLimits& limits = planner_.joint_limits();
    for (bool done = false; !done && out.seconds < 120; out.seconds += kStep_s) {
      second_last = last;
      last = q;
      done = motion.advance(planner_.arm(), kStep_s, q);
      observe_line(out, from, X_BT, tool(q));
      const auto qd = (q - last).cwiseAbs().array() / kStep_s;
      const auto qdd = (q - 2 * last + second_last).cwiseAbs().array() / (kStep_s * kStep_s);
      out.speed = std::max(out.speed, (qd / limits.speed.array()).maxCoeff());
      out.accel = std::max(out.accel, (qdd / limits.accel.array()).maxCoeff());
      out.beyond_rad =
          std::max({out.beyond_rad, (limits.lower - q).maxCoeff(), (q - limits.upper).maxCoeff()});
    }
    out.end = tool(q);
    return out;
  }

  /// Whether sampled postures on the line, every branch and elbow angle, have a continuous way from
  /// the start to the end with `margin_rad` to every limit.
  bool way_exists(const JointVector& start, const Eigen::Isometry3d& X_BT,
                  double margin_rad) const {
    const bool redundant = model().dof() > 6;
    const int layers = redundant ? 40 : 200, angles = redundant ? 90 : 1;
    const double near = redundant ? 0.12 : 0.05;
    const Eigen::Isometry3d from = tool(start);
    const Eigen::AngleAxisd turn(from.linear().transpose() * X_BT.linear());
    std::vector<JointVector> reached{start};
    for (int i = 1; i <= layers; ++i) {
      const double share = static_cast<double>(i) / layers;
      Eigen::Isometry3d X = from;
      X.translation() += share * (X_BT.translation() - from.translation());
      X.linear() =
          X.linear() * Eigen::AngleAxisd(share * turn.angle(), turn.axis()).toRotationMatrix();
      std::vector<JointVector> next;
      for (int k = 0; k < angles; ++k) {
        const double elbow = ik().elbow_of(start) + 2 * std::numbers::pi * (k + 0.0) / angles;
        for (const IkSolution& solution : ik().all(flange(X), elbow)) {
          if (!clear(solution.q, margin_rad)) continue;
          if (std::any_of(reached.begin(), reached.end(), [&](const JointVector& q) {
                return (q - solution.q).cwiseAbs().maxCoeff() < near;
              })) {
            next.push_back(solution.q);
          }
        }
      }
      if (next.empty()) return false;
      reached = std::move(next);
    }
    return true;
  }

  JointVector random_posture(std::mt19937& engine, double margin_rad) const {
    JointVector q(model().dof());
    for (int i = 0; i < model().dof(); ++i) {
      const Joint& joint = model().joints[static_cast<std::size_t>(i)];
      q(i) = std::uniform_real_distribution<double>(joint.lower_rad + margin_rad,
                                                    joint.upper_rad - margin_rad)(engine);
    }
    return q;
  }

 private:
  bool clear(const JointVector& q, double margin_rad) const {
    for (int i = 0; i < model().dof(); ++i) {
      const Joint& joint = model().joints[static_cast<std::size_t>(i)];
      if (q(i) < joint.lower_rad + margin_rad || q(i) > joint.upper_rad - margin_rad) return false;
    }
    return true;
  }

  static void observe_line(LineRun& out, const Eigen::Isometry3d& from, const Eigen::Isometry3d& to,
                           const Eigen::Isometry3d& here) {
    const Eigen::Vector3d way = to.translation() - from.translation();
    const Eigen::Vector3d d = here.translation() - from.translation();
    const Eigen::AngleAxisd turn(from.linear().transpose() * to.linear());
    const Eigen::AngleAxisd turned(from.linear().transpose() * here.linear());
    const bool advances = way.norm() > 1e-8, rotates = turn.angle() > 1e-8;
    double share = 0;
    if (advances) share = d.dot(way) / way.squaredNorm();
    if (!advances && rotates) share = turned.angle() / turn.angle();
    out.off_m = std::max(out.off_m, (d - share * way).norm());
    const Eigen::Matrix3d R =
        from.linear() * Eigen::AngleAxisd(share * turn.angle(), turn.axis()).toRotationMatrix();
    out.off_rad = std::max(out.off_rad, (R - here.linear()).norm());
  }

  ControllerSetup setup_;
  MotionPlanner planner_;
  ToolLimitSettings settings_;
};

void expect_kept(const LineRun& run, const Eigen::Isometry3d& to, const std::string& what) {
  EXPECT_LE(run.off_m, 1e-6) << what;
  EXPECT_LE(run.off_rad, 1e-6) << what;
  EXPECT_LE(run.speed, 1.01) << what;
  EXPECT_LE(run.accel, 1.1) << what;
  EXPECT_LE(run.beyond_rad, 0) << what;
  EXPECT_LE((run.end.translation() - to.translation()).norm(), 1e-9) << what;
  EXPECT_LE((run.end.linear() - to.linear()).norm(), 1e-8) << what;
}

std::string text_of(const JointVector& q, const Eigen::Isometry3d& from,
                    const Eigen::Isometry3d& to) {
  std::ostringstream text;
  text.precision(12);
  text << "q " << q.transpose() << " by " << (to.translation() - from.translation()).transpose()
       << " turn " << Eigen::AngleAxisd(from.linear().transpose() * to.linear()).angle();
  return text.str();
}

JointVector degrees_of(std::initializer_list<double> values) {
  JointVector q(static_cast<Eigen::Index>(values.size()));
  Eigen::Index i = 0;
  for (const double value : values) q(i++) = radians(value);
  return q;
}

Eigen::Isometry3d shifted(const Eigen::Isometry3d& X_BT, const Eigen::Vector3d& by_B,
                          const Eigen::Vector3d& turn_B = Eigen::Vector3d::Zero()) {
  Eigen::Isometry3d X = X_BT;
  X.translation() += by_B;
  if (turn_B.norm() > 0) {
    X.linear() =
        Eigen::AngleAxisd(turn_B.norm(), turn_B.normalized()).toRotationMatrix() * X_BT.linear();
  }
  return X;
}

/// Home has the axes 1 and 3 in line and the forearm level.
TEST(StraightLinePostures, TheSevenAxisArmJogsFromHomeInEveryDirection) {
  const LineArm arm("motoman");
  const Eigen::Isometry3d home = arm.tool(arm.home());
  for (int axis = 0; axis < 3; ++axis) {
    for (const double way : {1e-6, 1e-5, 1e-4, 1e-3, 0.01, 0.1, -1e-5, -1e-3, -0.01, -0.1}) {
      const Eigen::Isometry3d to = shifted(home, way * Eigen::Vector3d::Unit(axis));
      const LineRun run = arm.run(arm.home(), to);
      const std::string what = "axis " + std::to_string(axis) + " by " + std::to_string(way);
      ASSERT_TRUE(run.planned) << what << ": " << run.reason;
      expect_kept(run, to, what);
      EXPECT_LE(run.seconds, 0.5 + std::abs(way) / 0.25) << what;
    }
    for (const double turn : {1e-5, 1e-3, 0.02, 0.3, -1e-3, -0.02, -0.3}) {
      const Eigen::Isometry3d to =
          shifted(home, Eigen::Vector3d::Zero(), turn * Eigen::Vector3d::Unit(axis));
      const LineRun run = arm.run(arm.home(), to);
      const std::string what = "about axis " + std::to_string(axis) + " by " + std::to_string(turn);
      ASSERT_TRUE(run.planned) << what << ": " << run.reason;
      expect_kept(run, to, what);
      EXPECT_LE(run.seconds, 0.6 + 1.5 * std::abs(turn)) << what;
    }
  }
}

/// Lines whose middle has the wrist's axes in line, or nearly, in every direction.
TEST(StraightLinePostures, TheSevenAxisArmPassesAlignedWrists) {
  const LineArm arm("motoman");
  for (const JointVector& middle :
       {degrees_of({0, 30, 0, -80, 0, 0, 0}), degrees_of({20, 40, 10, -100, 0, 0, 30}),
        degrees_of({-40, 20, 30, -60, 40, 0, -40}), degrees_of({0, 50, 0, -90, 90, 0.3, 0}),
        degrees_of({10, 0, 0, -90, 0, -90, 0}), degrees_of({0, 0, 0, -100, 0, -50, 0})}) {
    for (const double length : {0.1, 0.2, 0.3}) {
      for (const Eigen::Vector3d& direction :
           {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1),
            Eigen::Vector3d(0.6, 0.8, 0), Eigen::Vector3d(0, 0.6, -0.8)}) {
        const Eigen::Isometry3d X = arm.tool(middle);
        const Eigen::Isometry3d to = shifted(X, length / 2 * direction);
        const Eigen::Isometry3d back = shifted(X, -length / 2 * direction);
        const std::string what = text_of(middle, back, to);
        // From the middle to one end, and from there through the middle to the other one.
        const LineRun out = arm.run(middle, to);
        if (!arm.way_exists(middle, to, 0.02)) continue;
        ASSERT_TRUE(out.planned) << what << ": " << out.reason;
        expect_kept(out, to, what);
        EXPECT_LE(out.seconds, 3) << what;
      }
    }
  }
}

class AnyLine : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Arms, AnyLine,
                         testing::Values("fanuc", "motoman", "ur5e", "irb120", "panda", "scara"),
                         [](const auto& arm) { return std::string(arm.param); });

/// Random postures, many of them with axes nearly in line: what sampled postures can do is planned.
TEST_P(AnyLine, ThatSampledPosturesCanDoIsPlannedAndKept) {
  const LineArm arm(GetParam());
  const bool redundant = arm.model().dof() > 6;
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  const bool scara = arm.model().dof() == 4;
  const bool of_the_cell =
      GetParam() == std::string("fanuc") || GetParam() == std::string("motoman");
  const int lines = of_the_cell ? kLines : aprsim::test::case_count(kLines);
  int planned = 0;
  for (int n = 0; n < lines; ++n) {
    JointVector q = arm.random_posture(engine, 0.05);
    // Axes of wrist and shoulder in line, or nearly.
    // Six axes have no freedom: closer to aligned than the samples are dense says nothing.
    constexpr std::array kOff{0.0, 1e-9, 1e-6, 1e-3, 0.02}, kSixAxes{0.0, 0.0, 1e-3, 5e-3, 0.02};
    const double off = (redundant ? kOff : kSixAxes)[static_cast<std::size_t>(n) % kOff.size()];
    if (n % 3 == 0 && !scara) q(redundant ? 5 : 4) = off;
    if (n % 4 == 0 && redundant) q(1) = off;
    // The arm as a whole is to be away from singular postures.
    if (redundant && dexterity(arm.model(), q) < kLeastDexterity) continue;
    const Eigen::Isometry3d from = arm.tool(q);
    const double size = n % 2 == 0 ? 0.05 : n % 5 == 0 ? 0.15 : 0.002;
    Eigen::Vector3d turn = 4 * size * Eigen::Vector3d(unit(engine), unit(engine), unit(engine));
    const Eigen::Vector3d way = size * Eigen::Vector3d(unit(engine), unit(engine), unit(engine));
    if (scara) turn.head<2>().setZero();
    const Eigen::Isometry3d to = shifted(from, way, turn);
    const LineRun run = arm.run(q, to);
    const std::string what = text_of(q, from, to);
    if (run.planned) {
      ++planned;
      expect_kept(run, to, what);
    } else {
      EXPECT_FALSE(arm.way_exists(q, to, 0.01)) << n << " " << what << ": " << run.reason;
    }
  }
  EXPECT_GE(planned, lines / 2);
}

}  // namespace
}  // namespace aprsim::robot
