#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "world/base/result.hpp"

namespace aprsim::robot {

inline constexpr int kMinDof = 4, kMaxDof = 7;
/// One value a joint [rad], of a prismatic joint [m]; lives on the stack.
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

/// Joint between links[i] and links[i + 1]. A prismatic joint has lengths [m] in the place of all
/// angles, a force [N] for its torque and a mass [kg] for its rotor inertia, also in joint vectors.
struct Joint {
  std::string name;
  bool prismatic = false;                                  ///< slides along the axis; else turns
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
  /// Flange in the frame that the last joint moves; none = the same.
  std::optional<Eigen::Isometry3d> X_LF;
  [[nodiscard]] int dof() const { return static_cast<int>(joints.size()); }
};

/// Reads a URDF file: one chain of 4 to 7 revolute, continuous or prismatic joints with axes in any
/// direction. Fixed joints are merged into their parent; the frame of the chain's last link is the
/// flange. A continuous joint gets limits of one turn either way. Rotor inertias come from
/// rotor_inertia.hpp, 0 where the file has none; a collision cylinder whose name ends in `_capsule`
/// becomes a CapsuleShape. Errors name the file, the element and what was expected. Thread: any;
/// one waits for another.
[[nodiscard]] Result<ArmModel> load_arm_model(const std::string& urdf_path);

}  // namespace aprsim::robot
