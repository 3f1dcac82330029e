#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "world/physics/bodies/contact_constraint.hpp"
#include "world/physics/bodies/rigid_body.hpp"
#include "world/physics/engine/contact_setting.hpp"
#include "world/physics/engine/joints.hpp"

namespace aprsim::physics {

class ContactSolverStatistics;

/// A step that is to be solved.
struct EngineStep {
  double step_s = 1e-3;
  Eigen::Vector3d gravity_W = Eigen::Vector3d::Zero();
  double residual_m_s = 1e-8;  ///< see scene::Physics
  std::uint64_t number = 0;    ///< of the step; the seed of an engine that draws at random
};

/// The end of a solve.
struct EngineOutcome {
  bool converged = true;
  int iterations = 0;
  double residual_m_s = 0;  ///< 0 if the engine measures none
};

/// An engine of rigid bodies: advances some bodies, with the joints and contacts between them, by
/// one step. All state between two steps is in the bodies, the JointForces and the contacts'
/// constraints, so that a step can be undone, saved and repeated. The gripper and contact
/// simplification use nothing else of an engine. Calls come in this order: begin(), bodies, joints,
/// contacts, advance(). The same calls give the same bits. Thread: one at a time; several engines
/// may run in several threads.
class Engine {
 public:
  virtual ~Engine() = default;

  /// Empties the system.
  virtual void begin(const EngineStep& step) = 0;
  /// Adds a body that the step moves, and clears its load, which acts in this step.
  virtual void add_body(RigidBody& body) = 0;
  /// Joins two bodies. Those that have not been added are kinematic.
  virtual void add_joint(const FixedJoint& joint) = 0;
  virtual void add_joint(const SliderJoint& joint) = 0;
  virtual void add_joint(const HingeJoint& joint) = 0;
  virtual void add_joint(const RodJoint& joint) = 0;
  /// A contact of two bodies; null = the ground. Contacts of the same two bodies follow each other.
  virtual void add_contact(RigidBody* a, RigidBody* b, ContactConstraint& constraint,
                           const ContactSetting& setting) = 0;
  /// Solves, moves the bodies that were added, and writes forces into the contacts' constraints
  /// and, of fixed joints at least, the JointForces.
  virtual EngineOutcome advance() = 0;
  /// The course of the last advance(); null if the engine records none.
  [[nodiscard]] virtual const ContactSolverStatistics* statistics() const { return nullptr; }
};

}  // namespace aprsim::physics
