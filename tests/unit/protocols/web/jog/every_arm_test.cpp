// Jogs of every shipped arm in its own cell, step by step.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "protocols/web/jog/jogger.hpp"
#include "protocols/web/jog/manual_mode.hpp"
#include "tests/support/cell_script.hpp"

namespace aprsim {
namespace {

struct JoggedArm {
  const char* scene;
  int robot;
};
void PrintTo(const JoggedArm& shown, std::ostream* out) {
  *out << shown.scene << ' ' << shown.robot;
}

/// Keeps what the jog sends until the next step.
class StepSink final : public api::CommandSink {
 public:
  Result<api::Ticket> submit(api::Command command) override {
    pending.push_back(std::move(command));
    return last + static_cast<api::Ticket>(pending.size());
  }
  std::vector<api::Command> pending;
  api::Ticket last = 0;
};

class EveryArm : public testing::TestWithParam<JoggedArm> {
 protected:
  static constexpr double kSpeed = 0.4;  ///< share of the manual speed
  static constexpr std::uint64_t kViewer = 1;

  void SetUp() override {
    write();
    cell_.act(robot_, api::InitRobot{});
    sink_.last = 1;
    write();
    rest();
  }

  [[nodiscard]] const api::RobotSnapshot& robot() const {
    return cell_.now.robots[static_cast<std::size_t>(robot_)];
  }
  [[nodiscard]] const api::RobotDescription& description() const {
    return cell_.now.cell->robots[static_cast<std::size_t>(robot_)];
  }
  [[nodiscard]] std::size_t axes() const { return description().joints.size(); }
  [[nodiscard]] std::vector<double> joints() const {
    std::vector<double> out;
    for (std::size_t i = 0; i < axes(); ++i) out.push_back(robot().joints[i].position_rad);
    return out;
  }

  void write() {
    cell_.world.write(cell_.now);
    cell_.now.cell = cell_.world.description();
    cell_.now.applied = sink_.last;
  }

  void step() {
    for (const api::Command& command : std::exchange(sink_.pending, {})) {
      cell_.world.apply(++sink_.last, std::get<api::RobotCommand>(command.body));
    }
    const Eigen::Vector3d before = robot().X_RT.p;
    cell_.world.step();
    write();
    now_ += std::chrono::milliseconds(1);
    fastest_m_s_ = std::max(fastest_m_s_, (robot().X_RT.p - before).norm() / 1e-3);
    jogger_.tick(cell_.now, now_);
  }

  /// Steps until the jog has ended and nothing moves.
  void rest() {
    for (int n = 0; n < 30'000; ++n) {
      step();
      if (!jogger_.active() && !robot().moving && sink_.pending.empty()) return;
    }
    FAIL() << "no rest";
  }

  /// Holds a jog for so long, releases it and waits for rest; the last error, if there was one.
  std::string hold(const v1::JogRequest& request, int milliseconds) {
    std::string reason;
    for (int n = 0; n < milliseconds; ++n) {
      if (n % 100 == 0) {
        const auto renewed = jogger_.renew(kViewer, request, cell_.now, now_);
        if (!renewed) reason = renewed.error().message;
      }
      step();
    }
    jogger_.release(kViewer);
    rest();
    return reason;
  }

  /// Makes one step of a jog; its error, if there was one.
  std::string make_step(const v1::JogRequest& request) {
    if (const auto begun = jogger_.step(kViewer, 7, request, cell_.now); !begun) {
      return begun.error().message;
    }
    for (int n = 0; n < 30'000; ++n) {
      step();
      const auto ended = jogger_.take_ended();
      if (ended.empty()) continue;
      rest();
      return ended[0].outcome ? "" : ended[0].outcome.error().message;
    }
    return "no end";
  }

  static v1::JogRequest joint(std::size_t index, bool negative, double step = 0) {
    v1::JogRequest request;
    request.set_speed(kSpeed);
    request.set_step(step);
    request.mutable_joint()->set_joint(static_cast<std::uint32_t>(index));
    request.mutable_joint()->set_negative(negative);
    return request;
  }
  static v1::JogRequest tool(const Eigen::Vector3d& axis, bool turning, double step = 0) {
    v1::JogRequest request;
    request.set_speed(kSpeed);
    request.set_step(step);
    v1::Vector3& out = turning ? *request.mutable_tool()->mutable_about()
                               : *request.mutable_tool()->mutable_along();
    out.set_x(axis.x());
    out.set_y(axis.y());
    out.set_z(axis.z());
    return request;
  }

  int robot_ = GetParam().robot;
  test::CellScript cell_{test::load_scene(GetParam().scene)};
  StepSink sink_;
  web::Jogger jogger_{robot_, 40, sink_, std::chrono::milliseconds(300)};
  web::Jogger::Clock::time_point now_;
  double fastest_m_s_ = 0;
};

TEST_P(EveryArm, JogsEachJointAlone) {
  const std::size_t count = axes();
  for (std::size_t i = 0; i < count; ++i) {
    for (const bool negative : {false, true}) {
      SCOPED_TRACE(testing::Message() << description().joints[i].name << (negative ? " -" : " +"));
      const auto before = joints();
      fastest_m_s_ = 0;
      EXPECT_EQ(hold(joint(i, negative), 300), "");
      const auto after = joints();
      const double way = (after[i] - before[i]) * (negative ? -1 : 1);
      EXPECT_GT(way, 1e-3);
      for (std::size_t k = 0; k < count; ++k) {
        if (k != i) {
          EXPECT_NEAR(after[k], before[k], 1e-9) << k;
        }
      }
      EXPECT_LE(fastest_m_s_, kSpeed * web::kManualSpeed_m_s * 1.01);
    }
  }
}

TEST_P(EveryArm, JogsTheToolAlongStraightLines) {
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0.6, 0.8, 0),
        Eigen::Vector3d(-0.6, -0.8, 0), Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0, 1, 0)}) {
    SCOPED_TRACE(testing::Message() << axis.transpose());
    const Pose before = robot().X_RT;
    fastest_m_s_ = 0;
    double off = 0, turned = 0;
    EXPECT_EQ(hold(tool(axis, false), 300), "");
    const Eigen::Vector3d way = robot().X_RT.p - before.p;
    off = (way - way.dot(axis) * axis).norm();
    turned = robot().X_RT.q.angularDistance(before.q);
    EXPECT_GT(way.dot(axis), 5e-3);
    EXPECT_LT(off, 1e-6);
    EXPECT_LT(turned, 1e-6);
    EXPECT_LE(fastest_m_s_, kSpeed * web::kManualSpeed_m_s * 1.01);
  }
}

TEST_P(EveryArm, TurnsTheToolAboutItsPointWhereItsAxesAllow) {
  const bool has_tilt = axes() > 5;
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0.6, 0.8, 0),
        Eigen::Vector3d(-0.6, -0.8, 0)}) {
    SCOPED_TRACE(testing::Message() << axis.transpose());
    const Pose before = robot().X_RT;
    const std::string reason = hold(tool(axis, true), has_tilt || axis.z() != 0 ? 300 : 1500);
    EXPECT_LT((robot().X_RT.p - before.p).norm(), 1e-6);
    if (axis.z() != 0 || has_tilt) {
      EXPECT_EQ(reason, "");
      EXPECT_GT(robot().X_RT.q.angularDistance(before.q), 1e-2);
    } else {
      EXPECT_NE(reason.find("tilted by"), std::string::npos) << reason;
      EXPECT_LT(robot().X_RT.q.angularDistance(before.q), 1e-6);
    }
  }
  // A refused jog is no fault of the robot.
  EXPECT_EQ(hold(tool(Eigen::Vector3d::UnitZ(), false), 300), "");
}

TEST_P(EveryArm, MakesStepsOfTheirLength) {
  for (std::size_t i = 0; i < axes(); ++i) {
    SCOPED_TRACE(description().joints[i].name);
    const double way = description().joints[i].prismatic ? 0.02 : 0.05;
    const auto before = joints();
    EXPECT_EQ(make_step(joint(i, true, way)), "");
    EXPECT_NEAR(joints()[i], before[i] - way, 1e-9);
    EXPECT_EQ(make_step(joint(i, false, way)), "");
    EXPECT_NEAR(joints()[i], before[i], 1e-9);
    // The longest step is one of an angle, or one of a length.
    const bool slides = description().joints[i].prismatic;
    EXPECT_NE(make_step(joint(i, true, slides ? 0.11 : 0.51))
                  .find(slides ? "is not within 0 and 0.1 m" : "is not within 0 and 0.5 rad"),
              std::string::npos);
  }
  const Pose before = robot().X_RT;
  EXPECT_EQ(make_step(tool(Eigen::Vector3d::UnitZ(), false, 0.03)), "");
  EXPECT_LT((robot().X_RT.p - before.p - Eigen::Vector3d(0, 0, 0.03)).norm(), 1e-8);
  EXPECT_EQ(make_step(tool(-Eigen::Vector3d::UnitZ(), false, 0.03)), "");
  EXPECT_LT((robot().X_RT.p - before.p).norm(), 1e-8);
}

TEST_P(EveryArm, JogsAJointToItsLimitAndNoFarther) {
  // The last joint's way is free of everything, and the slide's is the stroke upwards.
  const std::size_t last = axes() - 1;
  std::string reason;
  for (int n = 0; n < 60 && reason.empty(); ++n) reason = hold(joint(last, false), 2000);
  EXPECT_EQ(reason, "the joint is at its limit");
  EXPECT_NEAR(joints()[last], description().joints[last].upper_rad, 1e-9);
}

std::string name_of(const testing::TestParamInfo<JoggedArm>& which) {
  const std::string scene = which.param.scene;
  const std::array names{"ur5e", "irb120", "panda", "scara"};
  return scene == "arms" ? names[static_cast<std::size_t>(which.param.robot)]
                         : scene.substr(0, scene.find('_'));
}

INSTANTIATE_TEST_SUITE_P(Arms, EveryArm,
                         testing::Values(JoggedArm{"fanuc_only", 0}, JoggedArm{"motoman_only", 0},
                                         JoggedArm{"arms", 0}, JoggedArm{"arms", 1},
                                         JoggedArm{"arms", 2}, JoggedArm{"arms", 3}),
                         name_of);

}  // namespace
}  // namespace aprsim
