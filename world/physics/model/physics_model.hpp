#pragma once

#include <vector>

#include "world/physics/bodies/arm_links.hpp"
#include "world/physics/bodies/contact_constraint.hpp"
#include "world/physics/bodies/free_body.hpp"
#include "world/physics/bodies/static_shapes.hpp"
#include "world/physics/gripper/gripper_mechanism.hpp"
#include "world/physics/simplification/simplification.hpp"

namespace aprsim::physics {

/// Data that the parts of PhysicsWorld share: bodies, mechanisms, contact simplification, and the
/// contacts of the step.
struct PhysicsModel {
  PhysicsModel(const scene::Scene& the_scene, std::span<const robot::ArmModel> arm_models,
               std::span<const std::vector<Eigen::Isometry3d>> X_WL);

  const scene::Scene& scene;
  double step_s;  ///< length of the coming steps
  std::vector<scene::Tool> tools;
  BodyIds ids;
  MaterialTable materials;
  std::vector<FreeBody> bodies;
  StaticShapes fixed;
  std::vector<GripperMechanism> grippers;  ///< of each robot's tool, or of its empty flange
  /// Each tool's mechanism while no robot has it, else that of the robot's empty flange.
  std::vector<GripperMechanism> parked;
  std::vector<int> tool_of_robot;  ///< -1 = none
  std::vector<ArmLinks> arms;
  Simplification simplification;
  double belt_speed_m_s = 0;
  double lost_below_m = 0;                     ///< z in world under which nothing can catch a body
  std::vector<ContactConstraint> constraints;  ///< of the present step

  [[nodiscard]] FreeBody& body(int i) { return bodies[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const FreeBody& body(int i) const { return bodies[static_cast<std::size_t>(i)]; }
  void set_step_s(double s);
  /// Whether a gripper holds it.
  [[nodiscard]] bool is_held(int body) const;
  /// Upper bound of the displacement of any of a body's points in a step.
  [[nodiscard]] double displacement_m(int number) const;
  /// The mechanism of a tool, on a flange or not.
  [[nodiscard]] const GripperMechanism& mechanism(int tool) const;
  /// Sets the openings of all tools' shapes to those of their mechanisms.
  void open_tools();
  /// The rigid body that moves a body; null for kGround.
  [[nodiscard]] RigidBody* rigid_body(BodyIndex id);
  [[nodiscard]] Eigen::Vector3d gravity_W() const { return {0, 0, -scene.physics.gravity_m_s2}; }
};

}  // namespace aprsim::physics
