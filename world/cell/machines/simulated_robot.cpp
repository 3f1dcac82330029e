#include "world/cell/machines/simulated_robot.hpp"

#include <algorithm>
#include <cmath>

#include "world/api/commands/concurrent_action.hpp"
#include "world/cell/robot/collision_stop.hpp"
#include "world/cell/robot/robot_readings.hpp"
#include "world/cell/robot/robot_setup.hpp"
#include "world/cell/robot/tool_offset.hpp"
#include "world/robot/controller/guard_reaction.hpp"
#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::world {
namespace {

constexpr std::size_t kDescriptionCapacity = 512;

/// The same move without a check: a guard expects a touch.
api::RobotAction guarded(api::RobotAction action) {
  if (auto* to = std::get_if<api::MoveTo>(&action)) to->may_touch = true;
  if (auto* joints = std::get_if<api::MoveJoints>(&action)) joints->may_touch = true;
  return action;
}

}  // namespace

SimulatedRobot::SimulatedRobot(const scene::Scene& scene, std::size_t index,
                               const robot::ArmModel& model, robot::PlanPrefetcher* prefetcher,
                               const robot::SurroundingsSource* surroundings)
    : X_WB_(scene.robots[index].X_WB.isometry()),
      X_BR_(scene.robots[index].X_BR.isometry()),
      X_WR_(X_WB_ * X_BR_),
      tools_(scene.robots[index], scene::tools_of(scene)),
      start_tool_(scene::tools_at_start(scene)[index]),
      arm_(model, tools_.payload(start_tool_), gravity_in_base(scene.robots[index], scene.physics),
           home_of(scene.robots[index], model), scene.physics.step_s),
      ik_(inverse_kinematics_of(scene.robots[index], model)),
      controller_(controller_setup_of(
          scene.robots[index], model, ik_, scene.physics, tools_, start_tool_,
          {.prefetcher = prefetcher, .surroundings = surroundings, .index = index})),
      force_sensor_(scene.robots[index].force_sensor, scene.seed + index),
      guard_delay_(std::llround(scene.robots[index].guard_delay_s * 1e9)),
      step_size_(std::llround(scene.physics.step_s * 1e9)),
      X_WL_(model.links.size()),
      state_{.mount = ToolMount(start_tool_, Eigen::Isometry3d::Identity())} {
  guard_input_.action.description.reserve(kDescriptionCapacity);
  guard_input_.motion.alarm.reserve(kDescriptionCapacity);
  guard_input_.motion.commander.reserve(api::kMaxCommanderName);
  update_link_poses();
  state_.mount.step(X_WL_.back());
}

// ---- commands and faults

void SimulatedRobot::apply(api::Ticket ticket, const api::RobotCommand& command) {
  const api::RobotAction& action = command.action;
  if (!state_.faults.out_of_order.empty()) {
    return controller_.refuse(ticket, action, out_of_order());
  }
  const bool init =
      std::holds_alternative<api::InitRobot>(action) && !controller_.stream().active();
  if (init && !controller_.retreating()) arm_.relax();
  if (const auto* set = std::get_if<api::SetGripperForce>(&action)) {
    state_.pressure = std::min(1.0, set->force_n / tools_.full_grip_force_n(tool()));
  }
  const bool displaced = state_.faults.has_offset();
  const bool touches =
      !command.guards.empty() && controller_.planning() != api::PlanningMode::kDirect;
  if (displaced || touches) {
    api::RobotAction changed = displaced ? ToolOffset(state_.faults).displaced(action) : action;
    if (touches) changed = guarded(std::move(changed));
    controller_.apply(ticket, changed, arm_.q());
  } else {
    controller_.apply(ticket, action, arm_.q());
  }
  // The guards of a command that was refused as busy must not stop the stream.
  if (controller_.stream().active() && action_failed()) return state_.guards.reset();
  // A command beside a motion replaces its guards only if it has guards of its own.
  if (!command.guards.empty()) {
    state_.guards.begin(ticket, command.guards);
  } else if (!api::leaves_motion(action)) {
    state_.guards.reset();
  }
}

Result<void> SimulatedRobot::apply(api::Ticket ticket, const api::TrajectoryCommand& command) {
  std::int64_t delay = 0;
  bool resets = false;
  const auto* claim = std::get_if<api::ClaimMotion>(&command.action);
  const auto* follow = std::get_if<api::FollowTrajectory>(&command.action);
  if (claim) resets = claim->reset;
  if (follow) {
    resets = follow->reset;
    if (follow->start) delay = steps_until(*follow->start);
  }
  if ((claim || follow) && !state_.faults.out_of_order.empty()) {
    return fail(ErrorCode::kFailedPrecondition, "alarm", "alarm: " + out_of_order());
  }
  // As InitRobot does.
  const bool free = !controller_.stream().active() && !controller_.moving();
  if (resets && free) arm_.relax();
  return controller_.apply(ticket, command.action, delay, arm_.q());
}

Result<std::shared_ptr<robot::MovePreview>> SimulatedRobot::preview(
    const api::RobotAction& action, std::optional<api::PlanningMode> mode) const {
  if (!state_.faults.out_of_order.empty()) {
    return fail(ErrorCode::kFailedPrecondition, "robot", out_of_order());
  }
  const api::RobotAction real =
      state_.faults.has_offset() ? ToolOffset(state_.faults).displaced(action) : action;
  return std::visit(
      [&](const auto& move) -> Result<std::shared_ptr<robot::MovePreview>> {
        if constexpr (std::is_constructible_v<robot::PlannedMove, decltype(move)>) {
          return controller_.preview(move, mode);
        } else {
          return fail(ErrorCode::kInvalidArgument, "action", "only moves have a preview");
        }
      },
      real);
}

/// The steps that begin before a time; negative once it has passed.
std::int64_t SimulatedRobot::steps_until(SimTime time) const {
  const SimTime left = time - state_.now;
  return left.count() >= 0 ? (left + step_size_ - SimTime(1)) / step_size_ : -1;
}

void SimulatedRobot::set_faults(const RobotFaults& faults) {
  const bool stops = !faults.out_of_order.empty() && state_.faults.out_of_order.empty();
  const bool slows = faults.speed != state_.faults.speed;
  state_.faults = faults;
  arm_.set_torque_share(faults.torque);
  state_.joint_errors.begin(faults);
  if (slows) controller_.slow_down(faults.speed);
  if (stops) controller_.shut_down(out_of_order(), faults.brakes_on_path);
}

std::string SimulatedRobot::out_of_order() const {
  return "Out of order: " + state_.faults.out_of_order + "; once that is over, send InitCanon";
}

// ---- one step

void SimulatedRobot::step(const physics::GripperState& gripper,
                          std::span<const physics::ArmForce> forces,
                          const api::CellDescription& cell, std::span<const LooseTool> loose) {
  check_guards(gripper, forces);
  // Contact torques of the last step, then the controller's reference for this one.
  const ExternalTorque tau = external_torque(arm_, X_WB_, X_WL_, forces, state_.mount.has_tool());
  const robot::JointVector& reference =
      controller_.step({.gripper_settled = gripper.settled,
                        .tool_at_flange = tools_.within_capture(X_WL_.back(), loose),
                        .external_nm = tau.all,
                        .q_actual = arm_.q(),
                        .qd_actual = arm_.qd()});
  if (controller_.tool() != tool()) change_tool(loose);
  // The servo.
  arm_.set_applied_torque(controller_.applied_torque());
  arm_.set_braked(controller_.braked());
  arm_.step(reference, tau.all, tau.load);
  state_.now += step_size_;
  stop_if_collided(gripper, forces, cell);
  robot::finish_guards(state_.guards, controller_, state_.now);
  // The links and the tool follow.
  state_.joint_errors.step(arm_.q(), state_.faults, seconds(step_size_));
  update_link_poses();
  state_.mount.step(X_WL_.back());
}

/// Against the state at the end of the last step.
void SimulatedRobot::check_guards(const physics::GripperState& gripper,
                                  std::span<const physics::ArmForce> forces) {
  if (!state_.guards.active() && !state_.guards.reaction_due()) return;
  write(gripper, forces, guard_input_);
  robot::check_guards(state_.guards, controller_, guard_input_, state_.now, guard_delay_);
}

/// The tool changer has locked or released a tool.
void SimulatedRobot::change_tool(std::span<const LooseTool> loose) {
  const int tool = controller_.tool();
  if (tool < 0) {
    state_.mount.release();
  } else {
    const auto taken = std::ranges::find(loose, tool, &LooseTool::tool);
    state_.mount.couple(tool, taken == loose.end() ? X_WM() : tools_.mount_of(*taken));
  }
  arm_.set_payload(tools_.payload(tool));
}

void SimulatedRobot::update_link_poses() {
  if (state_.joint_errors.any()) {
    robot::link_poses(arm_.model(), state_.joint_errors.links_at(arm_.q()), X_WL_);
  } else {
    robot::link_poses(arm_.model(), arm_.q(), X_WL_);
  }
  for (auto& X : X_WL_) X = X_WB_ * X;
}

// ---- protective stops

void SimulatedRobot::stop_if_collided(const physics::GripperState& gripper,
                                      std::span<const physics::ArmForce> forces,
                                      const api::CellDescription& cell) {
  if (controller_.retreating()) return arm_.clear_trip();  // still in contact
  // Out of order and held by its brakes, it does not back off.
  if (!state_.faults.out_of_order.empty() && controller_.braked()) return arm_.clear_trip();
  // A robot that still brakes for the light curtain may yet collide.
  if (controller_.stopped_by_protection() && !controller_.moving()) return;
  const std::string reason =
      collision_message(arm_, gripper, state_.mount.has_tool(), forces, cell);
  if (reason.empty()) return;
  arm_.relax();
  controller_.protective_stop(reason, arm_.q());
}

void SimulatedRobot::stop_for_light_curtain() {
  if (controller_.stopped_by_protection()) return;
  controller_.protective_stop(
      "Protective stop: the light curtain is broken; clear it, then send InitCanon");
}

void SimulatedRobot::trip() {
  if (controller_.stopped_by_protection()) return;
  controller_.protective_stop("Protective stop: tripped; send InitCanon to go on");
}

// ---- state

ToolWrench SimulatedRobot::tool_wrench(std::span<const physics::ArmForce> forces) const {
  return world::tool_wrench(arm_.model().dof(), X_WR_, X_WT().translation(), forces,
                            state_.mount.has_tool());
}

void SimulatedRobot::write(const physics::GripperState& gripper,
                           std::span<const physics::ArmForce> forces,
                           api::RobotSnapshot& out) const {
  write_motion(arm_, X_BR_, controller_.X_FT(), out);
  out.X_WT = Pose::from(X_WT());
  const ToolWrench wrench = tool_wrench(forces);
  out.force_T_R = force_sensor_.reading(wrench.force_R, out.X_RT.q, state_.now);
  out.torque_T_R = wrench.torque_R;
  out.gripper = gripper_readings(gripper, controller_.gripper_setting(), set_gripper_force_n());
  write_controller(controller_, out);
  out.tool_mounted = state_.mount.has_tool();
  out.tool = tool();
  out.posture = ik_->posture_of(arm_.q());
  out.light_curtain_broken = state_.curtain_broken;
  out.guards = state_.guards.state();
  if (!state_.faults.has_offset()) return;
  const ToolOffset offset(state_.faults);
  out.X_RT = offset.reported(out.X_RT);
  if (out.X_RG) out.X_RG = offset.reported(*out.X_RG);
}

SimulatedRobot::State SimulatedRobot::save() const {
  return {arm_.state(), controller_.save(), state_};
}

void SimulatedRobot::restore(const State& state) {
  arm_.restore(state.arm);
  controller_.restore(state.controller);
  state_ = state.own;
  update_link_poses();
}

}  // namespace aprsim::world
