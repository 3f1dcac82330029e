#include "world/robot/kinematics/families/placed_ik.hpp"

#include <utility>

namespace aprsim::robot {

PlacedIk::PlacedIk(const ArmModel& model, Placement placement,
                   std::unique_ptr<const BranchedIk> family)
    : BranchedIk(model),
      placement_(std::move(placement)),
      X_AB_(placement_.X_BA.inverse()),
      X_FE_(placement_.X_EF.inverse()),
      family_(std::move(family)) {}

BranchedIk::Branches PlacedIk::branches(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                        double elbow_rad) const {
  Branches out = family_->branches(X_AB_ * X_BF * X_FE_, placement_.family(seed), elbow_rad);
  for (int b = 0; b < out.count; ++b) {
    JointVector& q = out.q[static_cast<std::size_t>(b)];
    q = (q - placement_.offset).cwiseProduct(placement_.sign).eval();
  }
  return out;
}

double PlacedIk::elbow_of(const JointVector& q) const {
  return family_->elbow_of(placement_.family(q));
}

api::Posture PlacedIk::posture_of(const JointVector& q) const {
  return family_->posture_of(placement_.family(q));
}

}  // namespace aprsim::robot
