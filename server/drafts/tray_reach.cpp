#include "server/drafts/tray_reach.hpp"

#include <cstddef>
#include <memory>
#include <numbers>
#include <optional>

#include "world/robot/kinematics/choice/make_inverse_kinematics.hpp"

namespace aprsim::server {
namespace {

constexpr int kDirections = 24;
constexpr double kAbove_m = 0.1;
constexpr std::size_t kMostSlots = 1000;  // of a draft, to bound the time for it

/// An arm with its tool of the start, at its place in the cell.
class Arm {
 public:
  Arm(const robot::InverseKinematics& ik, const api::RobotDescription& robot,
      const api::RobotSnapshot& state)
      : ik_(ik),
        X_BW_(robot.X_WB.isometry().inverse()),
        X_RW_(robot.X_BR.isometry().inverse() * X_BW_),
        X_TF_(robot.X_FT.isometry().inverse()),
        low_R_(robot.reach_min_R),
        high_R_(robot.reach_max_R),
        home_(robot::JointVector::Zero(static_cast<Eigen::Index>(robot.joints.size()))) {
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      home_[static_cast<Eigen::Index>(j)] = state.joints[j].position_rad;
    }
  }

  /// Slot frame S: z away from the tray.
  [[nodiscard]] bool grips_in(const Eigen::Isometry3d& X_WS) const {
    if (!may_reach(X_WS.translation())) return false;
    for (int i = 0; i < kDirections; ++i) {
      const double turn = 2 * std::numbers::pi * i / kDirections;
      const Eigen::Isometry3d X_ST(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) *
                                   Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
      const auto there = posture(X_WS * X_ST, home_);
      if (!there) continue;
      const Eigen::Isometry3d above = X_WS * Eigen::Translation3d(0, 0, kAbove_m) * X_ST;
      if (posture(above, *there)) return true;
    }
    return false;
  }

 private:
  [[nodiscard]] bool may_reach(const Eigen::Vector3d& p_W) const {
    const Eigen::Array3d p_R = X_RW_ * p_W;
    return (p_R >= low_R_.array()).all() && (p_R <= high_R_.array()).all();
  }
  [[nodiscard]] std::optional<robot::JointVector> posture(const Eigen::Isometry3d& X_WT,
                                                          const robot::JointVector& seed) const {
    const Eigen::Isometry3d X_BF = X_BW_ * X_WT * X_TF_;
    const auto elbow_rad = ik_.choose_elbow(X_BF, seed);
    if (!elbow_rad) return std::nullopt;
    const auto found = ik_.nearest(X_BF, seed, *elbow_rad);
    return found ? std::optional(*found) : std::nullopt;
  }

  const robot::InverseKinematics& ik_;
  const Eigen::Isometry3d X_BW_, X_RW_, X_TF_;
  const Eigen::Vector3d low_R_, high_R_;
  robot::JointVector home_;
};

}  // namespace

std::vector<web::SceneDraft::Reach> tray_reaches(const world::ArmModels& models,
                                                 const api::Snapshot& snapshot) {
  std::vector<web::SceneDraft::Reach> reaches;
  const api::CellDescription& cell = *snapshot.cell;
  std::size_t slots = 0;
  for (const api::BodyDescription& body : cell.bodies) slots += body.slots.size();
  if (slots > kMostSlots) return reaches;
  for (std::size_t r = 0; r < cell.robots.size(); ++r) {
    const auto ik = robot::make_inverse_kinematics((*models)[r]);
    if (!ik) continue;
    const Arm arm(**ik, cell.robots[r], snapshot.robots[r]);
    for (std::size_t b = 0; b < cell.bodies.size(); ++b) {
      web::SceneDraft::Reach reach{r, b, {}};
      const Eigen::Isometry3d X_WP = snapshot.bodies[b].X_WB.isometry();
      for (std::size_t s = 0; s < cell.bodies[b].slots.size(); ++s) {
        if (arm.grips_in(X_WP * cell.bodies[b].slots[s].X_PS.isometry())) reach.slots.push_back(s);
      }
      if (!cell.bodies[b].slots.empty()) reaches.push_back(std::move(reach));
    }
  }
  return reaches;
}

}  // namespace aprsim::server
