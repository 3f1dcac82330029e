#pragma once

#include <cstdint>
#include <memory>

#include <Eigen/Geometry>
#include <ode/ode.h>

/// Ownership of ODE objects: the only place that creates or destroys them by hand.
namespace aprsim::physics::ode {

template <auto destroy>
struct Destroy {
  template <typename T>
  void operator()(T* handle) const {
    destroy(handle);
  }
};

using World = std::unique_ptr<dxWorld, Destroy<dWorldDestroy>>;
using Body = std::unique_ptr<dxBody, Destroy<dBodyDestroy>>;
using Joint = std::unique_ptr<dxJoint, Destroy<dJointDestroy>>;
using JointGroup = std::unique_ptr<dxJointGroup, Destroy<dJointGroupDestroy>>;
using Geom = std::unique_ptr<dxGeom, Destroy<dGeomDestroy>>;

/// Initialises ODE once per process and installs handlers that throw PhysicsFailure instead of
/// ending the process.
void initialize();

/// How often ODE has complained about a nearly singular system in this thread.
[[nodiscard]] std::uint64_t complaints();

/// ODE keeps caches per thread; called at the start of everything that collides. Cheap.
void prepare_thread();

// ---- values across the border
[[nodiscard]] inline Eigen::Vector3d vector(const dReal* v) { return {v[0], v[1], v[2]}; }

[[nodiscard]] inline Eigen::Matrix3d matrix(const dReal* R) {
  Eigen::Matrix3d m;
  m << R[0], R[1], R[2], R[4], R[5], R[6], R[8], R[9], R[10];
  return m;
}

inline void copy(const Eigen::Vector3d& from, dReal* to) {
  to[0] = from.x();
  to[1] = from.y();
  to[2] = from.z();
}

inline void set_rotation(dBodyID body, const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  const dQuaternion ode_q = {q.w(), q.x(), q.y(), q.z()};
  dBodySetQuaternion(body, ode_q);
}

inline void set_position(dBodyID body, const Eigen::Vector3d& p) {
  dBodySetPosition(body, p.x(), p.y(), p.z());
}

inline void set_velocity(dBodyID body, const Eigen::Vector3d& v, const Eigen::Vector3d& omega) {
  dBodySetLinearVel(body, v.x(), v.y(), v.z());
  dBodySetAngularVel(body, omega.x(), omega.y(), omega.z());
}

inline void add_force(dBodyID body, const Eigen::Vector3d& f, const Eigen::Vector3d& torque) {
  dBodyAddForce(body, f.x(), f.y(), f.z());
  dBodyAddTorque(body, torque.x(), torque.y(), torque.z());
}

/// Mass about the body's origin, which ODE demands to be the centre of mass.
[[nodiscard]] inline dMass mass(double kg, const Eigen::Matrix3d& inertia) {
  dMass m;
  dMassSetParameters(&m, kg, 0, 0, 0, inertia(0, 0), inertia(1, 1), inertia(2, 2), inertia(0, 1),
                     inertia(0, 2), inertia(1, 2));
  return m;
}

/// Position, orientation and velocities as ODE holds them, bit for bit.
struct SavedState {
  dReal p[3] = {}, q[4] = {}, R[12] = {}, v[3] = {}, omega[3] = {};

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [p, q, R, v, omega] = self;
    io(p, q, R, v, omega);
  }
};
void save(dBodyID body, SavedState& to);
void restore(dBodyID body, const SavedState& from);

}  // namespace aprsim::physics::ode
