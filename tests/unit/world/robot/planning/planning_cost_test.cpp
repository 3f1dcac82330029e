#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/controller/controller_rig.hpp"
#include "world/robot/planning/motion_planner.hpp"
#include "world/robot/trajectory/profile/joint_limits.hpp"

namespace aprsim::robot {
namespace {

/// Counts the solutions asked for: the cost of planning, whatever the machine.
class CountingIk final : public InverseKinematics {
 public:
  CountingIk(std::shared_ptr<const InverseKinematics> inner, int& count)
      : inner_(std::move(inner)), count_(count) {}
  std::vector<IkSolution> all(const Eigen::Isometry3d& X_BF, double elbow) const override {
    ++count_;
    return inner_->all(X_BF, elbow);
  }
  Result<JointVector> nearest(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                              double elbow) const override {
    ++count_;
    return inner_->nearest(X_BF, seed, elbow);
  }
  api::Posture posture_of(const JointVector& q) const override { return inner_->posture_of(q); }
  double elbow_of(const JointVector& q) const override { return inner_->elbow_of(q); }
  Result<double> choose_elbow(const Eigen::Isometry3d& X_BF,
                              const JointVector& seed) const override {
    count_ += 170;  // its search round the circle
    return inner_->choose_elbow(X_BF, seed);
  }

 private:
  std::shared_ptr<const InverseKinematics> inner_;
  int& count_;
};

class PlanningCost : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Arms, PlanningCost, testing::Values("fanuc", "motoman"),
                         [](const auto& arm) { return std::string(arm.param); });

TEST_P(PlanningCost, IsBoundedForStraightLines) {
  const ControllerRig rig(GetParam());
  int count = 0;
  ControllerSetup setup = rig.setup();
  setup.ik = std::make_shared<CountingIk>(setup.ik, count);
  std::mt19937 engine(31);
  std::uniform_real_distribution<double> shift(-0.2, 0.2);
  std::vector<int> planned, refused;
  for (int n = 0; n < 200; ++n) {
    setup.q_home = rig.random_posture(engine, 0.05);
    RobotController controller(setup);
    controller.apply(1, api::InitRobot{}, setup.q_home);
    Eigen::Isometry3d X = rig.X_RT(setup.q_home);
    X.translation() += Eigen::Vector3d(shift(engine), shift(engine), shift(engine));
    count = 0;
    controller.apply(2, api::MoveTo{Pose::from(X), true}, setup.q_home);
    const bool ok = controller.status().state == api::ActionState::kWorking;
    (ok ? planned : refused).push_back(count);
  }
  std::sort(planned.begin(), planned.end());
  ASSERT_GT(planned.size(), 60u);
  EXPECT_LE(planned[planned.size() / 2], 100);
  // A redundant arm that cannot keep its elbow angle looks at all postures.
  const bool redundant = rig.model().dof() > 6;
  EXPECT_LE(planned[planned.size() * 95 / 100], redundant ? 3500 : 600);
  EXPECT_LE(planned.back(), redundant ? 15000 : 2500);
  EXPECT_LE(*std::max_element(refused.begin(), refused.end()), redundant ? 15000 : 2500);
}

/// One joint swung by a sine, far beyond its drive.
TEST_P(PlanningCost, TorqueScalingBringsADriveToItsShare) {
  const ControllerRig rig(GetParam());
  const ArmModel& model = rig.model();
  const auto& [payload, gravity_B] = std::pair(rig.setup().payload, rig.setup().gravity_B);
  for (int joint = 0; joint < model.dof(); ++joint) {
    const double frequency = 2 * 3.14159265358979 * 2, amplitude = 0.8, duration = 0.5;
    const auto position = [&, home = rig.setup().q_home](double t) {
      JointVector q = home;
      q(joint) += amplitude * std::sin(frequency * t);
      return q;
    };
    const double scale = torque_scaling(model, payload, gravity_B, duration, position);
    if (scale == 1) continue;
    ASSERT_GT(scale, 0.1);
    double share = 0;
    for (int k = 0; k < 400; ++k) {
      const double t = duration * k / 400, rate = frequency * scale;
      JointVector qd = JointVector::Zero(model.dof()), qdd = qd;
      qd(joint) = amplitude * rate * std::cos(frequency * t);
      qdd(joint) = -amplitude * rate * rate * std::sin(frequency * t);
      const auto torque = inverse_dynamics(model, payload, gravity_B, position(t), qd, qdd);
      for (int i = 0; i < model.dof(); ++i) {
        const auto slot = static_cast<std::size_t>(i);
        share = std::max(share, std::abs(torque(i)) / model.joints[slot].max_torque_nm);
      }
    }
    EXPECT_NEAR(share, kTorqueShare, 0.02) << joint;
  }
  const auto still = [&](double) { return rig.setup().q_home; };
  EXPECT_EQ(torque_scaling(model, payload, gravity_B, 1, still), 1.0);
  EXPECT_EQ(torque_scaling(model, payload, gravity_B, 0, still), 1.0);
}

TEST_P(PlanningCost, JointAccelerationsFitTheDrives) {
  const ControllerRig rig(GetParam());
  const JointLimits& limits = rig.limits();
  std::mt19937 engine(37);
  const JointVector rest = JointVector::Zero(rig.dof());
  for (int n = 0; n < 500; ++n) {
    const JointVector q = rig.random_posture(engine);
    const JointVector hold =
        inverse_dynamics(rig.model(), rig.setup().payload, rig.setup().gravity_B, q, rest, rest);
    const JointMatrix H = mass_matrix(rig.model(), rig.setup().payload, q);
    for (int i = 0; i < rig.dof(); ++i) {
      const double torque = std::abs(hold(i)) + H(i, i) * limits.accel(i);
      // The limits come from a sample of postures.
      EXPECT_LE(torque, 0.95 * rig.model().joints[static_cast<std::size_t>(i)].max_torque_nm);
      EXPECT_GE(limits.accel(i), 2.0);
    }
  }
}

}  // namespace
}  // namespace aprsim::robot
