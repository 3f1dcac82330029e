#include "clients/aprsim/files/reach.hpp"

#include <algorithm>
#include <memory>
#include <numbers>
#include <utility>

#include "world/robot/kinematics/choice/make_inverse_kinematics.hpp"
#include "world/robot/model/arm_model.hpp"
#include "world/scene/model/pieces.hpp"

namespace aprsim::client {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

struct Arm {
  Isometry3d X_BW, X_TF;
  robot::JointVector home;
  std::unique_ptr<robot::InverseKinematics> ik;

  [[nodiscard]] bool reaches(const Vector3d& p_W) const {
    constexpr int kYaws = 16;
    for (int i = 0; i < kYaws; ++i) {
      const Isometry3d X_WT =
          Eigen::Translation3d(p_W) *
          Eigen::AngleAxisd(2 * std::numbers::pi * i / kYaws, Vector3d::UnitZ()) *
          Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX());
      const Isometry3d X_BF = X_BW * X_WT * X_TF;
      const auto elbow = ik->choose_elbow(X_BF, home);
      if (elbow && ik->nearest(X_BF, home, *elbow)) return true;
    }
    return false;
  }
};

std::vector<Arm> arms_of(const scene::Scene& scene) {
  std::vector<Arm> arms;
  for (const scene::Robot& robot : scene.robots) {
    auto model = robot::load_arm_model(robot.model_file);
    if (!model) continue;
    auto ik = robot::make_inverse_kinematics(*model);
    if (!ik) continue;
    const auto joints = static_cast<Eigen::Index>(robot.home_rad.size());
    arms.push_back({.X_BW = robot.X_WB.isometry().inverse(),
                    .X_TF = robot.X_FT.isometry().inverse(),
                    .home = Eigen::Map<const Eigen::VectorXd>(robot.home_rad.data(), joints),
                    .ik = std::move(*ik)});
  }
  return arms;
}

}  // namespace

std::vector<std::string> bodies_out_of_reach(const scene::Scene& scene) {
  std::vector<std::string> out;
  const std::vector<Arm> arms = arms_of(scene);
  if (arms.empty()) return out;
  const auto check = [&](const std::string& name, const Vector3d& p_W) {
    if (std::ranges::none_of(arms, [&](const Arm& arm) { return arm.reaches(p_W); })) {
      out.push_back(name);
    }
  };
  for (const scene::GearInstance& gear : scene.gears) {
    const double disc_m = scene.gear_types.at(gear.type).disc_height_m;
    check(gear.name, gear.X_WP.isometry() * Vector3d(0, 0, disc_m));
  }
  for (const scene::PartInstance& part : scene.parts) {
    const auto box = scene::bounds_of(scene.part_types.at(part.type).pieces);
    const Vector3d top(box.center().x(), box.center().y(), box.max().z());
    check(part.name, part.X_WP.isometry() * top);
  }
  return out;
}

}  // namespace aprsim::client
