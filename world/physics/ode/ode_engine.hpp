#pragma once

#include <deque>
#include <vector>

#include "world/physics/engine/engine.hpp"
#include "world/physics/ode/ode_bodies.hpp"
#include "world/scene/model/ode_settings.hpp"

namespace aprsim::physics {

/// ODE as the engine: its bodies, joints, contacts and steppers, for comparison with the paper. It
/// is coarse: friction is a pyramid, sticking parts creep, and dWorldQuickStep ends after a fixed
/// number of iterations. The contact points are those of our own collision detection.
///
/// All state is in the RigidBodies; ODE's objects are set anew in each solve. dWorldQuickStep draws
/// the order of its constraints at random. Its seed is one for the whole process: it is set from
/// the number of the step, under a lock that engines in other threads wait for. dWorldStep draws
/// nothing and takes no lock. Each engine has a queue of jobs of its own, since ODE's default one
/// is shared and unguarded.
///
/// A solve that ODE cannot end, or whose result is not a number, counts as not converged, and its
/// bodies move freely in that step. ODE allocates in a step.
class OdeEngine final : public Engine {
 public:
  explicit OdeEngine(const scene::OdeSettings& settings);

  void begin(const EngineStep& step) override;
  void add_body(RigidBody& body) override { bodies_.add(body); }
  void add_joint(const FixedJoint& joint) override;
  void add_joint(const SliderJoint& joint) override;
  void add_joint(const HingeJoint& joint) override;
  void add_joint(const RodJoint& joint) override;
  void add_contact(RigidBody* a, RigidBody* b, ContactConstraint& constraint,
                   const ContactSetting& setting) override;
  EngineOutcome advance() override;

 private:
  /// The forces of a fixed joint are read after the step.
  struct Fixed {
    std::span<JointForce, 6> forces;
    Eigen::Matrix3d R_WJ;
    Eigen::Vector3d lever_W;  // from the centre of mass of a to that of b
    const dJointFeedback* feedback = nullptr;
  };
  struct Contact {
    ContactConstraint* constraint = nullptr;
    Eigen::Vector3d lever_W;  // from the centre of mass of a
    const dJointFeedback* feedback = nullptr;
  };
  /// Attaches a joint to bodies at the poses where it bears no force, sets it up there, and moves
  /// them back.
  template <typename SetUp>
  void attach_at(dxJoint* joint, RigidBody& a, const Eigen::Isometry3d& X_WA, RigidBody& b,
                 const Eigen::Isometry3d& X_WB, const SetUp& set_up);
  [[nodiscard]] const dJointFeedback* measure(dxJoint* joint);
  /// False if an assertion of ODE failed.
  [[nodiscard]] bool take_step();
  void step_world();
  void rebuild();
  void read_forces();

  scene::OdeSettings settings_;
  OdeThreading threading_;
  OdeWorld world_;
  OdeJointGroup joints_;
  OdeBodies bodies_;  // destroyed before the world
  EngineStep step_;
  std::deque<dJointFeedback> feedback_;  // at addresses that stay
  std::size_t feedback_count_ = 0;
  std::vector<Fixed> fixed_;
  std::vector<Contact> contacts_;
};

}  // namespace aprsim::physics
