#include "tests/unit/world/robot/controller/controller_rig.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "world/robot/kinematics/choice/make_inverse_kinematics.hpp"

namespace aprsim::robot {

namespace {

/// Figures of world/scenes/types/robots.yaml and arms.yaml, as far as motions depend on them.
struct RigArm {
  const char* name;
  const char* model;
  std::vector<double> home;  ///< [deg, mm]
  std::array<double, 4> tool_limits;
};

const std::array kRigArms{
    RigArm{"fanuc", "fanuc_lrmate200id", {0, 0, 0, 0, -90, 0}, {1.5, 5, 6, 30}},
    RigArm{"motoman", "motoman_sia20", {0, 0, 0, -90, 0, -90, 0}, {1.5, 5, 6, 30}},
    RigArm{"ur5e", "ur5e", {0, -90, 90, -90, -90, 0}, {1, 2.5, 3.1, 15}},
    RigArm{"irb120", "irb120", {0, 0, 0, 0, 90, 0}, {2, 5, 5, 25}},
    RigArm{"panda", "panda", {0, -45, 0, -135, 0, 90, 45}, {1.7, 5, 2.5, 12}},
    RigArm{"scara", "scara600", {-45, 90, -50, -45}, {2, 8, 8, 40}},
};

/// Tool and payload of a robot's gripper.
void equip(ControllerSetup& setup, const std::string& arm) {
  if (arm == "motoman") {
    setup.X_FT.translation() = Eigen::Vector3d(0, 0, 0.30187);
    setup.payload = {4.24, {0, 0.02, 0.15}, Eigen::Vector3d(0.028, 0.028, 0.014).asDiagonal()};
  } else if (arm == "fanuc") {
    // Tool z along flange x.
    setup.X_FT.linear() =
        Eigen::AngleAxisd(radians(90), Eigen::Vector3d::UnitY()).toRotationMatrix();
    setup.X_FT.translation() = Eigen::Vector3d(0.194, 0, 0);
    setup.payload = {1.3, {0.09, 0, 0}, Eigen::Vector3d(1e-3, 2.2e-3, 2.2e-3).asDiagonal()};
  } else {
    setup.X_FT.translation() = Eigen::Vector3d(0, 0, 0.194);
    setup.payload = {1, {0, 0, 0.09}, Eigen::Vector3d(2e-3, 2e-3, 1e-3).asDiagonal()};
  }
}

}  // namespace

ControllerSetup rig_setup(const std::string& arm) {
  const auto entry =
      std::ranges::find_if(kRigArms, [&](const RigArm& known) { return arm == known.name; });
  if (entry == kRigArms.end()) throw std::runtime_error("no arm " + arm);
  auto model =
      load_arm_model(std::string(APRSIM_SOURCE_DIR) + "/world/models/" + entry->model + ".urdf");
  if (!model) throw std::runtime_error(model.error().message);
  auto ik = make_inverse_kinematics(*model);
  if (!ik) throw std::runtime_error(ik.error().message);
  ControllerSetup setup;
  setup.q_home.resize(model->dof());
  for (int i = 0; i < model->dof(); ++i) {
    const double home = entry->home[static_cast<std::size_t>(i)];
    setup.q_home(i) =
        model->joints[static_cast<std::size_t>(i)].prismatic ? home / 1000 : radians(home);
  }
  equip(setup, arm);
  // The reference frame differs from the base, so that a confusion of the two would show.
  setup.X_BR = Eigen::Translation3d(0.1, -0.2, 0.3) *
               Eigen::AngleAxisd(radians(30), Eigen::Vector3d::UnitZ());
  setup.model = std::move(*model);
  setup.ik = std::move(*ik);
  const auto& [trans_speed, trans_accel, rot_speed, rot_accel] = entry->tool_limits;
  setup.max_trans_speed_m_s = trans_speed;
  setup.max_trans_accel_m_s2 = trans_accel;
  setup.max_rot_speed_rad_s = rot_speed;
  setup.max_rot_accel_rad_s2 = rot_accel;
  return setup;
}

api::MoveJoints move_all(const JointVector& q) {
  api::MoveJoints move;
  for (int i = 0; i < q.size(); ++i) move.targets.push_back({i, q(i), {}, {}});
  return move;
}

ControllerRig::ControllerRig(const std::string& arm) : ControllerRig(rig_setup(arm)) {}

ControllerRig::ControllerRig(ControllerSetup setup)
    : setup_(std::move(setup)),
      limits_(derive_joint_limits(setup_.model, setup_.payload, setup_.gravity_B)),
      controller_(setup_) {
  path_.reserve(200000);
  forget();
}

void ControllerRig::step(bool gripper_settled) {
  path_.push_back(controller_.step({.gripper_settled = gripper_settled}));
}

api::ActionState ControllerRig::run(const api::RobotAction& action, double limit_s) {
  apply(action);
  for (int i = 0; i < limit_s / setup_.step_s && state() == api::ActionState::kWorking; ++i) step();
  return state();
}

void ControllerRig::ready() {
  run(api::InitRobot{});
  JointVector q(dof());
  if (dof() == 6) {
    q << 0.2, 0.4, -0.4, 0.1, -0.9, 0.3;
  } else {
    q << 0.2, 0.5, 0.3, -1.4, 0.2, -1.0, 0.3;
  }
  run(move_all(q));
  forget();
}

void ControllerRig::rest(double limit_s) {
  for (int i = 0; i < limit_s / setup_.step_s && controller_.moving(); ++i) step();
}

Eigen::Isometry3d ControllerRig::X_RT(const JointVector& q) const {
  return setup_.X_BR.inverse() * flange_pose(setup_.model, q) * setup_.X_FT;
}

JointVector ControllerRig::random_posture(std::mt19937& engine, double margin) const {
  JointVector q(dof());
  for (int i = 0; i < dof(); ++i) {
    const Joint& joint = setup_.model.joints[static_cast<std::size_t>(i)];
    q(i) = std::uniform_real_distribution<double>(joint.lower_rad + margin,
                                                  joint.upper_rad - margin)(engine);
  }
  return q;
}

api::RobotAction ControllerRig::random_command(std::mt19937& engine) const {
  std::uniform_real_distribution<double> shift(-0.15, 0.15), share(0.05, 1), speed(0.05, 3);
  const auto kind = std::uniform_int_distribution<int>(0, 11)(engine);
  Pose X = tool();
  X.p += Eigen::Vector3d(shift(engine), shift(engine), shift(engine));
  X.q = X.q * Eigen::Quaterniond(Eigen::AngleAxisd(
                  4 * shift(engine), Eigen::Vector3d(share(engine), 0, 1).normalized()));
  switch (kind) {
    case 0:
      return move_all(random_posture(engine));
    case 1: {
      const int joint = std::uniform_int_distribution<int>(0, dof() - 1)(engine);
      const JointVector q = random_posture(engine);
      return api::MoveJoints{{{joint, q(joint), speed(engine), {}},
                              {(joint + 1) % dof(), q((joint + 1) % dof()), {}, {}}}};
    }
    case 2:
    case 3:
      return api::MoveTo{Pose::from(X_RT(random_posture(engine))), false};
    case 4:
      return api::MoveTo{X, false};
    case 5:
      return api::StopMotion{
          static_cast<api::StopKind>(std::uniform_int_distribution<int>(0, 2)(engine))};
    case 6:
      return api::SetMotionLimit{
          static_cast<api::MotionLimit>(std::uniform_int_distribution<int>(0, 3)(engine)), true,
          share(engine)};
    case 7:
      return api::Dwell{std::chrono::milliseconds(20)};
    default:
      return api::MoveTo{X, true};
  }
}

ControllerRig::Effort ControllerRig::effort() const {
  Effort out;
  const double dt = setup_.step_s;
  for (std::size_t k = 1; k < path_.size(); ++k) {
    const JointVector qd = (path_[k] - path_[k - 1]) / dt;
    out.speed = std::max(out.speed, (qd.cwiseAbs().array() / limits_.speed.array()).maxCoeff());
    const Eigen::Isometry3d a = X_RT(path_[k - 1]), b = X_RT(path_[k]);
    const Eigen::Vector3d v = (b.translation() - a.translation()) / dt;
    out.tool_speed = std::max(out.tool_speed, v.norm());
    out.tool_turn = std::max(out.tool_turn,
                             Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle() / dt);
    if (k < 2) continue;
    const JointVector qdd = (path_[k] - 2 * path_[k - 1] + path_[k - 2]) / (dt * dt);
    out.accel = std::max(out.accel, (qdd.cwiseAbs().array() / limits_.accel.array()).maxCoeff());
    const Eigen::Vector3d v0 = (a.translation() - X_RT(path_[k - 2]).translation()) / dt;
    out.tool_accel = std::max(out.tool_accel, (v - v0).norm() / dt);
    if (k < 3) continue;
    const JointVector qddd =
        (path_[k] - 3 * path_[k - 1] + 3 * path_[k - 2] - path_[k - 3]) / (dt * dt * dt);
    out.jerk = std::max(out.jerk, (qddd.cwiseAbs().array() / limits_.jerk.array()).maxCoeff());
  }
  return out;
}

}  // namespace aprsim::robot
