#include "world/physics/model/body_state.hpp"

#include "world/physics/model/physics_model.hpp"

namespace aprsim::physics {
namespace {

/// A sleeping body moves with its carrier; its own record is not read.
BodyState sleeping_state(const SleepingGroups& sleeping, int body) {
  BodyState state;
  state.p_WB = sleeping.p_WB(body);
  state.q_WB = sleeping.q_WB(body);
  state.v_W = sleeping.velocity(body);
  state.resting = true;
  state.group_kind = api::GroupKind::kDormant;
  state.group = sleeping.lowest(body);
  return state;
}

}  // namespace

BodyState body_state(const PhysicsModel& model, int body) {
  const auto& simplification = model.simplification;
  if (simplification.dormant(body)) return sleeping_state(simplification.sleeping(), body);
  const FreeBody& free = model.body(body);
  BodyState state;
  state.p_WB = free.X_WB.translation();
  state.q_WB = Eigen::Quaterniond(free.X_WB.linear());
  state.omega_W = free.omega_W;
  // Velocity of the frame's origin: v_com + omega x (origin - com).
  state.v_W = free.v_com_W - free.omega_W.cross(free.X_WB.linear() * free.mass.com);
  state.resting = simplification.resting(body);
  state.lost_step = free.lost_step;
  state.group_kind = simplification.group_kind(body);
  state.group = simplification.group(body);
  return state;
}

BodyState tool_state(const PhysicsModel& model, int tool) {
  const int body = model.ids.tool(tool);
  if (!model.body(body).mounted) return body_state(model, body);
  const GripperMechanism& gripper = model.mechanism(tool);
  BodyState state;
  state.p_WB = gripper.state().X_WT.p;
  state.q_WB = gripper.state().X_WT.q;
  state.v_W = gripper.mount_velocity(state.p_WB);
  state.omega_W = gripper.mount_omega();
  return state;
}

}  // namespace aprsim::physics
