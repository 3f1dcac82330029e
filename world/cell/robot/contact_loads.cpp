#include "world/cell/robot/contact_loads.hpp"

#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::world {
namespace {

bool loads_arm(const physics::ArmForce& force, bool has_tool) {
  return !force.relayed && (has_tool || !force.on_gripper);
}

}  // namespace

ExternalTorque external_torque(const robot::ServoArm& arm, const Eigen::Isometry3d& X_WB,
                               std::span<const Eigen::Isometry3d> X_WL,
                               std::span<const physics::ArmForce> forces, bool has_tool) {
  ExternalTorque tau;
  tau.all = tau.load = robot::JointVector::Zero(arm.model().dof());
  for (const auto& force : forces) {
    if (!loads_arm(force, has_tool)) continue;
    const auto& link = X_WL[static_cast<std::size_t>(force.link)];
    const auto J =
        robot::point_jacobian(arm.model(), arm.q(), force.link, link.inverse() * force.p_W);
    const robot::JointVector part =
        J.topRows<3>().transpose() * (X_WB.linear().transpose() * force.f_W);
    tau.all += part;
    const bool body = force.partner.kind == api::ContactSide::Kind::kBody;
    if (force.on_gripper && body) tau.load += part;
  }
  return tau;
}

ToolWrench tool_wrench(int flange, const Eigen::Isometry3d& X_WR, const Eigen::Vector3d& p_WT,
                       std::span<const physics::ArmForce> forces, bool has_tool) {
  ToolWrench out;
  const Eigen::Matrix3d R_RW = X_WR.linear().transpose();
  for (const auto& force : forces) {
    if (force.link != flange || !loads_arm(force, has_tool)) continue;
    out.force_R += R_RW * force.f_W;
    out.torque_R += R_RW * (force.p_W - p_WT).cross(force.f_W);
  }
  return out;
}

}  // namespace aprsim::world
