#include "world/robot/kinematics/dynamics.hpp"

#include <array>
#include <cassert>
#include <cstddef>

#include <Eigen/Geometry>

#include "world/robot/model/joint_rotation.hpp"

namespace aprsim::robot {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// One value a link; index 0 is the base.
template <typename T>
using PerLink = std::array<T, kMaxDof + 1>;

/// |p|^2 1 - p p^T: rotational inertia of a unit point mass at p.
Matrix3d point_inertia(const Vector3d& p) {
  return p.squaredNorm() * Matrix3d::Identity() - p * p.transpose();
}

struct Body {
  double mass = 0;
  Vector3d com = Vector3d::Zero();
  Matrix3d inertia = Matrix3d::Zero();  ///< about the com
};

void add_payload(const Link& link, const Payload& payload, Body& out) {
  out.mass = link.mass_kg + payload.mass_kg;
  const Vector3d apart = payload.com_F - link.com_L;
  out.com += apart * (payload.mass_kg / out.mass);
  // Two bodies about their common centre: reduced mass m1 m2 / (m1 + m2) times the squared
  // distance.
  out.inertia +=
      payload.inertia_F + (link.mass_kg * payload.mass_kg / out.mass) * point_inertia(apart);
}

/// Link i in the frame that its joint moves, the last one combined with the payload (parallel axis
/// theorem).
Body body(const ArmModel& model, const Payload& payload, int i) {
  const Link& link = model.links[static_cast<std::size_t>(i)];
  Body out{link.mass_kg, link.com_L, link.inertia_L};
  if (i != model.dof()) return out;
  if (payload.mass_kg > 0) add_payload(link, payload, out);
  if (model.X_LF) {
    out.com = *model.X_LF * out.com;
    out.inertia = model.X_LF->linear() * out.inertia * model.X_LF->linear().transpose();
  }
  return out;
}
/// Steps from a link to the next one outwards.
void advance(Eigen::Isometry3d& X_BL, const Joint& joint, double q) {
  X_BL.translation() += X_BL.linear() * joint.X_PJ.translation();
  Eigen::Matrix3d R_BL = X_BL.linear() * joint.X_PJ.linear();
  if (joint.prismatic) {
    X_BL.translation() += R_BL * joint.axis * q;
  } else {
    rotate_by(R_BL, joint.axis, q);
  }
  X_BL.linear() = R_BL;
}

}  // namespace

/// Product of the joint transforms from the base outwards.
void link_poses(const ArmModel& model, const JointVector& q, std::span<Eigen::Isometry3d> X_BL) {
  assert(q.size() == model.dof() && X_BL.size() == model.links.size());
  X_BL[0].setIdentity();
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    X_BL[i + 1] = X_BL[i];
    advance(X_BL[i + 1], model.joints[i], q(static_cast<Eigen::Index>(i)));
  }
  if (model.X_LF) X_BL.back() = X_BL.back() * *model.X_LF;
}

Eigen::Isometry3d flange_pose(const ArmModel& model, const JointVector& q) {
  assert(q.size() == model.dof());
  Eigen::Isometry3d X_BL = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    advance(X_BL, model.joints[i], q(static_cast<Eigen::Index>(i)));
  }
  if (model.X_LF) X_BL = X_BL * *model.X_LF;
  return X_BL;
}

/// Geometric Jacobian: columns z x (p - o) and z of revolute joints, z and 0 of prismatic ones
/// (Siciliano et al. 2009, sec. 3.1).
Jacobian point_jacobian(const ArmModel& model, const JointVector& q, int link,
                        const Eigen::Vector3d& p_L) {
  assert(q.size() == model.dof() && link >= 0 && link <= model.dof());
  Jacobian J = Jacobian::Zero(6, model.dof());
  Eigen::Isometry3d X_BL = Eigen::Isometry3d::Identity();
  for (int i = 0; i < link; ++i) {
    const Joint& joint = model.joints[static_cast<std::size_t>(i)];
    advance(X_BL, joint, q(i));
    // The axis is invariant under the joint's own rotation. The upper rows hold the joint's origin
    // until the point is known.
    J.block<3, 1>(3, i) = X_BL.linear() * joint.axis;
    J.block<3, 1>(0, i) = X_BL.translation();
  }
  if (link == model.dof() && model.X_LF) X_BL = X_BL * *model.X_LF;
  const Eigen::Vector3d p_B = X_BL * p_L;
  for (int i = 0; i < link; ++i) {
    const Eigen::Vector3d axis = J.block<3, 1>(3, i);
    if (model.joints[static_cast<std::size_t>(i)].prismatic) {
      J.block<3, 1>(0, i) = axis;
      J.block<3, 1>(3, i).setZero();
      continue;
    }
    const Eigen::Vector3d lever = p_B - J.block<3, 1>(0, i);
    J.block<3, 1>(0, i) = axis.cross(lever);
  }
  return J;
}

// Recursive Newton-Euler algorithm: Luh, Walker & Paul 1980; Featherstone 2008, sec. 5.3, here with
// 3-D vectors. Everything is in axes of the link it belongs to, moments about that link's origin.
// Gravity enters as an upward acceleration of the base.
JointVector inverse_dynamics(const ArmModel& model, const Payload& payload,
                             const Vector3d& gravity_B, const JointVector& q, const JointVector& qd,
                             const JointVector& qdd) {
  const int n = model.dof();
  assert(q.size() == n && qd.size() == n && qdd.size() == n);
  PerLink<Matrix3d> R_PL;
  PerLink<Vector3d> force, moment;
  Vector3d omega = Vector3d::Zero(), alpha = Vector3d::Zero(), accel = -gravity_B;
  // Outwards: velocities and accelerations of the links, and the forces and moments that these
  // take.
  for (int i = 1; i <= n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const Joint& joint = model.joints[at - 1];
    const Vector3d p = joint_offset(joint, q(i - 1));
    R_PL[at] = joint_rotation(joint, q(i - 1));
    accel = R_PL[at].transpose() * (accel + alpha.cross(p) + omega.cross(omega.cross(p)));
    const Vector3d rate = joint.axis * qd(i - 1);
    omega = R_PL[at].transpose() * omega;
    alpha = R_PL[at].transpose() * alpha;
    if (joint.prismatic) {
      // Sliding, with the Coriolis acceleration.
      accel += joint.axis * qdd(i - 1) + 2 * omega.cross(rate);
    } else {
      omega += rate;
      alpha = alpha + joint.axis * qdd(i - 1) + omega.cross(rate);
    }

    // Newton and Euler, about the link's origin.
    const Body b = body(model, payload, i);
    force[at] = b.mass * (accel + alpha.cross(b.com) + omega.cross(omega.cross(b.com)));
    moment[at] = b.inertia * alpha + omega.cross(b.inertia * omega) + b.com.cross(force[at]);
  }
  // Inwards: each joint transmits the sum of all beyond it; its torque is the part along its axis.
  JointVector tau(n);
  for (int i = n; i >= 1; --i) {
    const auto at = static_cast<std::size_t>(i);
    const Joint& joint = model.joints[at - 1];
    tau(i - 1) = joint.axis.dot(joint.prismatic ? force[at] : moment[at]) +
                 joint.rotor_inertia_kg_m2 * qdd(i - 1);
    if (i == 1) break;
    const Vector3d f_P = R_PL[at] * force[at];
    force[at - 1] += f_P;
    moment[at - 1] += R_PL[at] * moment[at] + joint_offset(joint, q(i - 1)).cross(f_P);
  }
  return tau;
}

// Composite-rigid-body algorithm: Walker & Orin 1982; Featherstone 2008, sec. 6.2.
JointMatrix mass_matrix(const ArmModel& model, const Payload& payload, const JointVector& q) {
  const int n = model.dof();
  assert(q.size() == n);
  // The composite body outboard of each joint: mass, mass times com, inertia about the origin.
  double mass = 0;
  Vector3d first_moment = Vector3d::Zero();
  Matrix3d inertia = Matrix3d::Zero();
  PerLink<Matrix3d> R_PL;
  for (int i = 1; i <= n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    R_PL[at] = joint_rotation(model.joints[at - 1], q(i - 1));
  }
  JointMatrix H(n, n);
  for (int i = n; i >= 1; --i) {
    const auto at = static_cast<std::size_t>(i);
    // The composite, moved to this link's origin (parallel axes), and the link itself.
    if (i < n) {
      const Joint& outer = model.joints[at];
      const Vector3d p = joint_offset(outer, q(i));
      const Vector3d h = R_PL[at + 1] * first_moment;
      inertia = R_PL[at + 1] * inertia * R_PL[at + 1].transpose() + mass * point_inertia(p) +
                2 * p.dot(h) * Matrix3d::Identity() - p * h.transpose() - h * p.transpose();
      first_moment = h + mass * p;
    }
    const Body b = body(model, payload, i);
    mass += b.mass;
    first_moment += b.mass * b.com;
    inertia += b.inertia + b.mass * point_inertia(b.com);

    // Force and moment that accelerate the composite by 1 rad/s^2 (m/s^2) about (along) joint i,
    // handed inwards.
    const Joint& joint = model.joints[at - 1];
    Vector3d force = joint.axis.cross(first_moment);
    Vector3d moment = inertia * joint.axis;
    if (joint.prismatic) {
      force = mass * joint.axis;
      moment = first_moment.cross(joint.axis);
    }
    H(i - 1, i - 1) = joint.axis.dot(joint.prismatic ? force : moment) + joint.rotor_inertia_kg_m2;
    for (int k = i; k > 1; --k) {
      const auto outer = static_cast<std::size_t>(k);
      force = R_PL[outer] * force;
      moment = R_PL[outer] * moment + joint_offset(model.joints[outer - 1], q(k - 1)).cross(force);
      const Joint& inner = model.joints[outer - 2];
      H(k - 2, i - 1) = H(i - 1, k - 2) = inner.axis.dot(inner.prismatic ? force : moment);
    }
  }
  return H;
}

}  // namespace aprsim::robot
