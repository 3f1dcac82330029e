#pragma once

#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "world/base/result.hpp"

namespace aprsim::robot {

inline constexpr int kMaxDof = 7;
/// One value a joint; lives on the stack.
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxDof, 1>;
using JointMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxDof, kMaxDof>;
/// Rows: linear velocity, then angular velocity.
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxDof>;

struct BoxShape {
  Eigen::Vector3d size;
};
struct CapsuleShape {
  double radius_m = 0, length_m = 0;  ///< length of the cylinder part, along z
};
struct CylinderShape {
  double radius_m = 0, length_m = 0;
};
struct SphereShape {
  double radius_m = 0;
};
struct LinkShape {
  Eigen::Isometry3d X_LS = Eigen::Isometry3d::Identity();  ///< shape in link
  std::variant<BoxShape, CapsuleShape, CylinderShape, SphereShape> shape;
};

/// A shape as it looks; none of a mesh file.
struct LinkVisual {
  LinkShape shape;
  Eigen::Vector3d colour = Eigen::Vector3d::Constant(0.5);  ///< sRGB, 0 to 1
};

struct Link {
  std::string name;
  double mass_kg = 0;
  Eigen::Vector3d com_L = Eigen::Vector3d::Zero();      ///< centre of mass in link frame
  Eigen::Matrix3d inertia_L = Eigen::Matrix3d::Zero();  ///< about the com, link axes
  std::vector<LinkShape> collision;
  std::vector<LinkVisual> visual;
};

/// Revolute joint between links[i] and links[i + 1].
struct Joint {
  std::string name;
  Eigen::Isometry3d X_PJ = Eigen::Isometry3d::Identity();  ///< joint frame in parent at q = 0
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();         ///< in joint frame
  double lower_rad = 0, upper_rad = 0;
  double max_speed_rad_s = 0;
  double max_torque_nm = 0;
  double rotor_inertia_kg_m2 = 0;  ///< reflected to the joint
};

/// A serial arm: base link, dof joints, dof links; the last link's frame is the flange.
struct ArmModel {
  std::string name;
  std::vector<Joint> joints;
  std::vector<Link> links;  ///< dof + 1, links[0] = base
  [[nodiscard]] int dof() const { return static_cast<int>(joints.size()); }
};

/// Reads a URDF file: one chain of revolute joints; fixed joints are merged into their parent, so a
/// trailing `flange` link must coincide with the last moving link. Rotor inertias come from
/// rotor_inertia.hpp; a collision cylinder whose name ends in `_capsule` becomes a CapsuleShape.
/// Errors name the file, the element and what was expected. Thread: any; one waits for another.
[[nodiscard]] Result<ArmModel> load_arm_model(const std::string& urdf_path);

}  // namespace aprsim::robot
