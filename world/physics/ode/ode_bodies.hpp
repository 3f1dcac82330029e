#pragma once

#include <memory>
#include <vector>

#include <ode/ode.h>

#include "world/physics/bodies/rigid_body.hpp"

namespace aprsim::physics {

/// Destroys an object of ODE.
template <auto destroy>
struct OdeDestroy {
  template <typename T>
  void operator()(T* handle) const {
    destroy(handle);
  }
};
using OdeWorld = std::unique_ptr<dxWorld, OdeDestroy<dWorldDestroy>>;
using OdeThreading =
    std::unique_ptr<dxThreadingImplementation, OdeDestroy<dThreadingFreeImplementation>>;
using OdeJointGroup = std::unique_ptr<dxJointGroup, OdeDestroy<dJointGroupDestroy>>;

[[nodiscard]] inline Eigen::Vector3d from_ode(const dReal* v) { return {v[0], v[1], v[2]}; }

/// The bodies of an ODE world that stand for RigidBodies in one solve. They are kept from solve to
/// solve, and get all of their state anew.
class OdeBodies {
 public:
  explicit OdeBodies(dxWorld* world) : world_(world) {}

  /// Forgets the bodies of the last solve.
  void clear();
  /// A body that the solve moves, with its load.
  void add(RigidBody& body);
  /// The body in ODE; one that was not added is kinematic. Null for null.
  [[nodiscard]] dxBody* find(RigidBody* body);
  [[nodiscard]] bool moves(const RigidBody* body) const;
  /// After a step that `ended`: poses and velocities back into the RigidBodies that were added.
  /// False if it did not end or one of them is not a number, and then none is changed.
  [[nodiscard]] bool read_back(bool ended);
  /// Moves the bodies without any joint or contact instead.
  void move_freely(double step_s, const Eigen::Vector3d& gravity_W);

 private:
  struct Destroy {
    void operator()(dxBody* body) const { dBodyDestroy(body); }
  };
  struct Member {
    std::unique_ptr<dxBody, Destroy> handle;
    RigidBody* body = nullptr;
    bool moves = false;
  };
  Member& next(RigidBody& body, bool moves);

  dxWorld* world_;
  std::vector<Member> members_;  // as many as there ever were
  std::size_t count_ = 0;
};

/// Sets the pose of a body in ODE.
void set_ode_pose(dxBody* body, const Eigen::Vector3d& p_W, const Eigen::Quaterniond& q_WB);

}  // namespace aprsim::physics
