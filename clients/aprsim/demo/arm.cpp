#include "clients/aprsim/demo/arm.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "clients/aprsim/cli/interruption.hpp"
#include "clients/aprsim/demo/geometry.hpp"

namespace aprsim::client {
namespace {

constexpr CrclSession::Seconds kMoveTimeout{90};
constexpr double kTurn_deg_s = 90;
constexpr double kHome_s = 4;    // duration of the return, for every joint
constexpr double kThere = 1e-3;  // tolerance of the home position [degrees or pulses]

}  // namespace

Arm::Arm(CrclSession session, v1::RobotDescription description)
    : session_(std::move(session)), description_(std::move(description)) {
  X_RW_ = (isometry(description_.base_in_world()) * isometry(description_.reference_in_base()))
              .inverse();
  if (description_.has_tool_point_in_flange()) {
    X_TP_ = isometry(description_.tool_in_flange()).inverse() *
            isometry(description_.tool_point_in_flange());
  }
}

Outcome<Arm> Arm::connect(const Endpoints& endpoints, const v1::RobotDescription& description) {
  auto session = CrclSession::connect(endpoints, description.name(), interruption::requested);
  if (!session) return tl::unexpected(session.error());
  Arm arm(std::move(*session), description);
  if (auto done = arm.initialise(); !done) return tl::unexpected(done.error());
  const crcl::CommandBody settings[] = {
      crcl::SetUnits{crcl::LengthUnit::kMillimeter}, crcl::SetUnits{crcl::AngleUnit::kDegree},
      crcl::SetRate{crcl::RateKind::kRotSpeed, {.relative = false, .value = kTurn_deg_s}}};
  for (const auto& setting : settings) {
    if (auto done = arm.run(setting); !done) return tl::unexpected(done.error());
  }
  const auto status = arm.session_.status();
  if (!status) return tl::unexpected(status.error());
  arm.home_ = status->joints;
  return arm;
}

Eigen::Vector3d Arm::p_WB() const { return isometry(description_.base_in_world()).translation(); }

Eigen::Isometry3d Arm::X_WT(const v1::RobotState& state) const {
  return isometry(state.tool_in_world()) * X_TP_.inverse();
}

Outcome<void> Arm::run(crcl::CommandBody body) {
  const auto status = session_.run(std::move(body), kMoveTimeout);
  if (!status) return tl::unexpected(status.error());
  return {};
}

Outcome<void> Arm::initialise() { return run(crcl::InitCanon{}); }

Outcome<void> Arm::move(const Eigen::Isometry3d& X_WT, bool straight) {
  crcl::MoveTo move;
  move.straight = straight;
  move.end.pose = crcl_pose_mm(X_RW_ * X_WT * X_TP_);
  return run(move);
}

Outcome<void> Arm::set_speed(double m_s) {
  return run(crcl::SetRate{crcl::RateKind::kTransSpeed, {.relative = false, .value = 1e3 * m_s}});
}

Outcome<void> Arm::set_gripper(bool open) { return run(crcl::SetEndEffector{open ? 1.0 : 0.0}); }

Outcome<void> Arm::dwell(double span_s) { return run(crcl::Dwell{span_s}); }

Outcome<void> Arm::go_home() {
  const auto now = session_.status();
  if (!now) return tl::unexpected(now.error());
  crcl::ActuateJoints joints;
  for (const auto& joint : home_) {
    const auto at = std::ranges::find(now->joints, joint.joint, &crcl::JointStatus::joint);
    if (!joint.position || at == now->joints.end() || !at->position) continue;
    // Proportional to the distance, so that all joints arrive together.
    const double way = std::abs(*joint.position - *at->position);
    crcl::ActuateJoint actuate{joint.joint, *joint.position, crcl::JointSpeedAccel{}};
    if (way > kThere) actuate.details = crcl::JointSpeedAccel{way / kHome_s, {}};
    joints.joints.push_back(actuate);
  }
  return joints.joints.empty() ? Outcome<void>() : run(joints);
}

Outcome<void> Arm::end() { return run(crcl::EndCanon{}); }

Failure Arm::stopped_after(const Failure& failure) { return session_.stopped_after(failure); }

}  // namespace aprsim::client
