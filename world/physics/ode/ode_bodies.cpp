#include "world/physics/ode/ode_bodies.hpp"

#include "world/physics/bodies/free_rotation.hpp"

namespace aprsim::physics {
namespace {

Eigen::Quaterniond attitude_of(dxBody* handle) {
  const dReal* q = dBodyGetQuaternion(handle);
  return {q[0], q[1], q[2], q[3]};
}

bool is_finite(dxBody* handle) {
  return from_ode(dBodyGetPosition(handle)).allFinite() &&
         attitude_of(handle).coeffs().allFinite() &&
         from_ode(dBodyGetLinearVel(handle)).allFinite() &&
         from_ode(dBodyGetAngularVel(handle)).allFinite();
}

}  // namespace

void set_ode_pose(dxBody* body, const Eigen::Vector3d& p_W, const Eigen::Quaterniond& q_WB) {
  const dQuaternion q = {q_WB.w(), q_WB.x(), q_WB.y(), q_WB.z()};
  dBodySetQuaternion(body, q);
  dBodySetPosition(body, p_W.x(), p_W.y(), p_W.z());
}

void OdeBodies::clear() {
  // A disabled body without joints takes no part in a step.
  for (std::size_t i = 0; i < count_; ++i) dBodyDisable(members_[i].handle.get());
  count_ = 0;
}

OdeBodies::Member& OdeBodies::next(RigidBody& body, bool moves) {
  if (count_ == members_.size()) {
    members_.emplace_back().handle.reset(dBodyCreate(world_));
    dBodySetFiniteRotationMode(members_.back().handle.get(), 1);
  }
  Member& member = members_[count_];
  body.set_system_index(static_cast<int>(count_++));
  member.body = &body;
  member.moves = moves;
  dxBody* handle = member.handle.get();
  dBodyEnable(handle);
  set_ode_pose(handle, body.p_W(), body.q_WB());
  dBodySetLinearVel(handle, body.v_W().x(), body.v_W().y(), body.v_W().z());
  dBodySetAngularVel(handle, body.omega_W().x(), body.omega_W().y(), body.omega_W().z());
  return member;
}

void OdeBodies::add(RigidBody& body) {
  dxBody* handle = next(body, true).handle.get();
  const Eigen::Matrix3d& I = body.inertia_B();
  dMass mass;
  dMassSetParameters(&mass, body.mass_kg(), 0, 0, 0, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2),
                     I(1, 2));
  dBodySetDynamic(handle);
  dBodySetMass(handle, &mass);
  dBodySetGravityMode(handle, body.is_ballistic() ? 1 : 0);
  dBodySetGyroscopicMode(handle, body.is_ballistic() ? 1 : 0);
  dBodySetForce(handle, body.force_W().x(), body.force_W().y(), body.force_W().z());
  dBodySetTorque(handle, body.torque_W().x(), body.torque_W().y(), body.torque_W().z());
}

dxBody* OdeBodies::find(RigidBody* body) {
  if (body == nullptr) return nullptr;
  if (body->system_index() < 0) {
    dxBody* handle = next(*body, false).handle.get();
    dBodySetKinematic(handle);
    dBodySetForce(handle, 0, 0, 0);
    dBodySetTorque(handle, 0, 0, 0);
  }
  return members_[static_cast<std::size_t>(body->system_index())].handle.get();
}

bool OdeBodies::moves(const RigidBody* body) const {
  return body != nullptr && members_[static_cast<std::size_t>(body->system_index())].moves;
}

bool OdeBodies::read_back(bool ended) {
  bool finite = ended;
  for (std::size_t i = 0; i < count_; ++i) {
    members_[i].body->set_system_index(-1);
    finite = finite && is_finite(members_[i].handle.get());
  }
  for (std::size_t i = 0; i < count_ && finite; ++i) {
    const Member& member = members_[i];
    if (!member.moves) continue;
    dxBody* handle = member.handle.get();
    member.body->set_position(from_ode(dBodyGetPosition(handle)));
    member.body->set_orientation(attitude_of(handle));
    member.body->set_velocity(from_ode(dBodyGetLinearVel(handle)),
                              from_ode(dBodyGetAngularVel(handle)));
    member.body->clear_load();
  }
  return finite;
}

void OdeBodies::move_freely(double step_s, const Eigen::Vector3d& gravity_W) {
  for (std::size_t i = 0; i < count_; ++i) {
    if (!members_[i].moves) continue;
    RigidBody& body = *members_[i].body;
    const Eigen::Vector3d v_W =
        body.is_ballistic() ? Eigen::Vector3d(body.v_W() + step_s * gravity_W) : body.v_W();
    body.set_position(body.p_W() + step_s * v_W);
    body.set_orientation(rotation_by(step_s * body.omega_W()) * body.q_WB());
    body.set_velocity(v_W, body.omega_W());
    body.clear_load();
  }
}

}  // namespace aprsim::physics
