#pragma once

#include <memory>

#include <Eigen/Geometry>
#include <ode/ode.h>

/// Ownership of ODE's objects, and values across its border.
namespace aprsim::bench::ode {

template <auto destroy>
struct Destroy {
  template <typename T>
  void operator()(T* handle) const {
    destroy(handle);
  }
};

using World = std::unique_ptr<dxWorld, Destroy<dWorldDestroy>>;
using Body = std::unique_ptr<dxBody, Destroy<dBodyDestroy>>;
using JointGroup = std::unique_ptr<dxJointGroup, Destroy<dJointGroupDestroy>>;

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

}  // namespace aprsim::bench::ode
