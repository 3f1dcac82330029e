#include "world/cell/robot/tool_payload.hpp"

#include "world/scene/model/tool.hpp"

namespace aprsim::world {

robot::Payload gripper_payload(const scene::Gripper& gripper, const Eigen::Isometry3d& X_FT) {
  robot::Payload payload;
  payload.mass_kg = gripper.mount_mass_kg + gripper.palm_mass_kg + 2 * gripper.finger_mass_kg;
  const Eigen::Vector3d com_T(0, 0, -gripper.pad_height_m - 0.5 * gripper.palm_size.z());
  payload.com_F = X_FT * com_T;
  const Eigen::Vector3d s2 = gripper.palm_size.cwiseAbs2();
  const Eigen::Vector3d inertia_T =
      payload.mass_kg / 12.0 * Eigen::Vector3d(s2.y() + s2.z(), s2.x() + s2.z(), s2.x() + s2.y());
  payload.inertia_F = X_FT.linear() * inertia_T.asDiagonal() * X_FT.linear().transpose();
  return payload;
}

robot::Payload changer_payload(const scene::Robot& robot) {
  robot::Payload payload;
  payload.mass_kg = robot.changer.mass_kg;
  payload.com_F = 0.5 * scene::coupling_of(robot).p;
  return payload;
}

robot::Payload joined(const robot::Payload& a, const robot::Payload& b) {
  if (a.mass_kg <= 0) return b;
  robot::Payload sum;
  sum.mass_kg = a.mass_kg + b.mass_kg;
  sum.com_F = (a.mass_kg * a.com_F + b.mass_kg * b.com_F) / sum.mass_kg;
  // Parallel axes.
  const auto about_sum = [&sum](const robot::Payload& part) {
    const Eigen::Vector3d r = part.com_F - sum.com_F;
    return (part.inertia_F +
            part.mass_kg * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose()))
        .eval();
  };
  sum.inertia_F = about_sum(a) + about_sum(b);
  return sum;
}

}  // namespace aprsim::world
