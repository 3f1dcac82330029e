#pragma once

#include <vector>

#include "world/physics/arm_bodies.hpp"
#include "world/physics/fixed_shapes.hpp"
#include "world/physics/free_bodies.hpp"
#include "world/physics/gripper.hpp"
#include "world/physics/ode_handles.hpp"
#include "world/physics/simplification.hpp"
#include "world/physics/touch.hpp"

namespace aprsim::physics {

/// Everything that PhysicsWorld's parts share. Members that own ODE bodies and joints come after
/// the world they live in.
struct Cell {
  Cell(const scene::Scene& the_scene, std::span<const robot::ArmModel> models,
       std::span<const std::vector<Eigen::Isometry3d>> X_WL);

  const scene::Scene& scene;
  double step_s;
  ode::World world;
  NodeNumbers nodes;
  std::vector<FreeBody> bodies;
  FixedShapes fixed;
  std::vector<GripperMechanism> grippers;
  std::vector<ArmBodies> arms;
  Simplification simplification;
  double belt_speed_m_s = 0;
  std::vector<Touch> touches;  ///< of the present step

  [[nodiscard]] FreeBody& body(int i) { return bodies[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const FreeBody& body(int i) const { return bodies[static_cast<std::size_t>(i)]; }
  /// The ODE body that moves a node; null for kGround.
  [[nodiscard]] dBodyID ode_body(BodyIndex node) const;
  /// What a touch's second side is called; for a robot's part, the robot's name.
  [[nodiscard]] std::string_view name_of(BodyIndex node, int fixed_shape) const;
};

}  // namespace aprsim::physics
