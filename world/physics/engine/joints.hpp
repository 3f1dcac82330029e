#pragma once

#include <optional>
#include <span>

#include <Eigen/Geometry>

#include "world/physics/bodies/rigid_body.hpp"
#include "world/physics/engine/joint_force.hpp"

/// The joints that every engine offers. Frames A and B are those of the bodies, with the origins at
/// their centres of mass; forces act on the first body.
namespace aprsim::physics {

/// Both bodies keep the relative pose that they have at `X_WA` and `X_WB`.
struct FixedJoint {
  RigidBody& a;
  RigidBody& b;
  Eigen::Isometry3d X_WA = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  Eigen::Matrix3d R_WJ = Eigen::Matrix3d::Identity();  ///< axes of the forces
  /// From the centre of mass of a to the point of a that holds that of b.
  Eigen::Vector3d lever_W = Eigen::Vector3d::Zero();
  /// Implicit spring with damper against translation, as ODE's ERP and CFM [m/(s N)].
  struct Spring {
    double erp = 0, cfm = 0;
  };
  std::optional<Spring> spring;     ///< none: stiff
  double compliance = 0;            ///< of all that is stiff [m/(s N)]; an engine may use its own
  std::span<JointForce, 6> forces;  ///< force and torque at the centre of mass of b
};

/// The first body slides along its y axis on the second one, with all axes parallel, between two
/// end stops and driven by a motor of limited force.
struct SliderJoint {
  RigidBody& a;
  RigidBody& b;
  Eigen::Vector3d p_BA = Eigen::Vector3d::Zero();  ///< at travel 0
  double sign = 1;                                 ///< travel grows along y, or against it
  double travel_m = 0;                             ///< present one
  double end_m = 0;      ///< travel at the upper stop; the lower one is at 0
  double speed_m_s = 0;  ///< that the motor aims at
  double force_n = 0;    ///< of the motor, at most
  std::span<JointForce, 5> rail;
  JointForce& motor;
  JointForce& lower_stop;
  JointForce& upper_stop;
};

/// The first body turns about its z axis, which stays parallel to that of the second one.
struct HingeJoint {
  RigidBody& a;
  RigidBody& b;
  Eigen::Vector3d p_BA = Eigen::Vector3d::Zero();
  std::span<JointForce, 5> forces;
};

/// A rod of constant length between a point of either body.
struct RodJoint {
  RigidBody& a;
  RigidBody& b;
  Eigen::Vector3d p_A = Eigen::Vector3d::Zero(), p_B = Eigen::Vector3d::Zero();
  double length_m = 0;
  JointForce& force;
};

}  // namespace aprsim::physics
