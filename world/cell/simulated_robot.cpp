#include "world/cell/simulated_robot.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "world/api/commands/beside_motion.hpp"
#include "world/api/snapshot/contact_names.hpp"
#include "world/cell/describe_cell.hpp"
#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::world {
namespace {

/// A deflection of the mount beyond this is a collision of the gripper.
constexpr double kMaxPalmDeflection_m = 3e-3;
/// In which the tool changer draws a tool in.
constexpr int kPullSteps = 100;
constexpr std::size_t kDescriptionCapacity = 512;
/// At which an injected error of an encoder comes and goes [rad/s].
constexpr double kBendSpeed = 0.2;
/// From a move's command to its motion: an interpolation cycle of an ordinary robot controller, and
/// what long or searched paths take more.
constexpr robot::PlanningLatency kPlanningLatency{
    .base_s = 8e-3, .waypoint_s = 1e-3, .screw_s = 40e-3, .search_s = 0.25};

/// One value a joint, or an exception.
robot::JointVector home_of(const scene::Robot& robot, const robot::ArmModel& model) {
  if (static_cast<int>(robot.home_rad.size()) != model.dof()) {
    throw std::runtime_error("robot " + robot.name + ": home has " +
                             std::to_string(robot.home_rad.size()) + " values, the model " +
                             std::to_string(model.dof()) + " joints");
  }
  return Eigen::Map<const Eigen::VectorXd>(robot.home_rad.data(), model.dof());
}

/// Mount, palm and fingers as one box around the palm's centre, which sits behind the finger pads.
robot::Payload payload_of(const scene::Gripper& gripper, const Eigen::Isometry3d& X_FT) {
  robot::Payload payload;
  payload.mass_kg = gripper.mount_mass_kg + gripper.palm_mass_kg + 2 * gripper.finger_mass_kg;
  const Eigen::Vector3d com_T(0, 0, -gripper.pad_height_m - 0.5 * gripper.palm_size.z());
  payload.com_F = X_FT * com_T;
  const Eigen::Vector3d s2 = gripper.palm_size.cwiseAbs2();
  const Eigen::Vector3d inertia_T =
      payload.mass_kg / 12.0 * Eigen::Vector3d(s2.y() + s2.z(), s2.x() + s2.z(), s2.x() + s2.y());
  payload.inertia_F = X_FT.linear() * inertia_T.asDiagonal() * X_FT.linear().transpose();
  return payload;
}

/// What stays on the flange, halfway to its coupling, and with a tool that on it.
robot::Payload changer_payload(const scene::Robot& robot) {
  robot::Payload payload;
  payload.mass_kg = robot.changer.mass_kg;
  payload.com_F = 0.5 * scene::coupling_of(robot).p;
  return payload;
}

robot::Payload joined(const robot::Payload& a, const robot::Payload& b) {
  if (a.mass_kg <= 0) return b;
  robot::Payload sum;
  sum.mass_kg = a.mass_kg + b.mass_kg;
  sum.com_F = (a.mass_kg * a.com_F + b.mass_kg * b.com_F) / sum.mass_kg;
  const auto about_sum = [&sum](const robot::Payload& part) {
    const Eigen::Vector3d r = part.com_F - sum.com_F;
    return (part.inertia_F +
            part.mass_kg * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose()))
        .eval();
  };
  sum.inertia_F = about_sum(a) + about_sum(b);
  return sum;
}

/// The tool's own frame in the flange; that of the robot's own gripper as the scene has it.
Eigen::Isometry3d frame_of(const scene::Tool& tool, const scene::Robot& robot) {
  return scene::coupling_of(robot).isometry() * tool.X_QT.isometry();
}

std::vector<robot::ToolSetup> tool_setups_of(const scene::Robot& robot,
                                             const std::vector<scene::Tool>& tools) {
  std::vector<robot::ToolSetup> setups;
  for (const scene::Tool& tool : tools) {
    const Eigen::Isometry3d X_FT = frame_of(tool, robot);
    setups.push_back({.X_FT = robot.tool_point_F ? robot.tool_point_F->isometry() : X_FT,
                      .payload = joined(changer_payload(robot), payload_of(tool.gripper, X_FT))});
  }
  return setups;
}

Eigen::Vector3d gravity_in_base(const scene::Robot& robot, const scene::Physics& physics) {
  return robot.X_WB.q.inverse() * Eigen::Vector3d(0, 0, -physics.gravity_m_s2);
}

std::shared_ptr<const robot::InverseKinematics> ik_of(const scene::Robot& robot,
                                                      const robot::ArmModel& model) {
  auto ik = robot::make_inverse_kinematics(model);
  if (!ik) throw std::runtime_error("robot " + robot.name + ": " + ik.error().message);
  return std::move(*ik);
}

robot::ControllerSetup setup_of(const scene::Robot& robot, const robot::ArmModel& model,
                                std::shared_ptr<const robot::InverseKinematics> ik,
                                const scene::Physics& physics, std::vector<robot::ToolSetup> tools,
                                int tool, robot::PlanPrefetcher* prefetcher) {
  return {.model = model,
          .ik = std::move(ik),
          .X_BR = robot.X_BR.isometry(),
          .X_FT_open = robot.tool_point_F.value_or(Pose{}).isometry(),
          .q_home = home_of(robot, model),
          .step_s = physics.step_s,
          .max_trans_speed_m_s = robot.max_trans_speed_m_s,
          .max_trans_accel_m_s2 = robot.max_trans_accel_m_s2,
          .max_rot_speed_rad_s = robot.max_rot_speed_rad_s,
          .max_rot_accel_rad_s2 = robot.max_rot_accel_rad_s2,
          .payload_open = changer_payload(robot),
          .tools = std::move(tools),
          .tool = tool,
          .tool_change_s = robot.changer.time_s,
          .gravity_B = gravity_in_base(robot, physics),
          .latency = kPlanningLatency,
          .prefetcher = prefetcher};
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

/// Bound of the tool point's distance from axis 1 at the height of axis 2: the sum of the lengths
/// from the second joint on, and the radius of the circle on which the first joint moves that one.
double reach_of(const robot::ArmModel& model, const Eigen::Isometry3d& X_FT) {
  double reach = X_FT.translation().norm();
  for (std::size_t i = 2; i < model.joints.size(); ++i) {
    reach += model.joints[i].X_PJ.translation().norm();
  }
  return reach + model.joints[1].X_PJ.translation().head<2>().norm();
}

/// The largest contact force, those of the grip on a held body left out.
const physics::ArmForce* largest(std::span<const physics::ArmForce> forces, int held_body) {
  const auto grip = [held_body](const physics::ArmForce& force) {
    return force.on_gripper && !force.relayed && held_body >= 0 &&
           force.partner.kind == api::ContactSide::Kind::kBody && force.partner.index == held_body;
  };
  const physics::ArmForce* most = nullptr;
  for (const auto& force : forces) {
    if (grip(force)) continue;
    if (!most || force.f_W.squaredNorm() > most->f_W.squaredNorm()) most = &force;
  }
  return most;
}

/// A value on its way to another, by at most `most`.
double towards(double value, double goal, double most) {
  return value + std::clamp(goal - value, -most, most);
}

/// Where the tool goes instead of where it is sent.
struct Offset {
  Eigen::Isometry3d before, behind;

  explicit Offset(const RobotFaults& faults)
      : before(faults.base_offset.isometry()), behind(faults.tool_offset.isometry()) {}
  [[nodiscard]] Pose sent(const Pose& X_RT) const {
    return Pose::from(before * X_RT.isometry() * behind);
  }
  [[nodiscard]] Pose reported(const Pose& X_RT) const {
    return Pose::from(before.inverse() * X_RT.isometry() * behind.inverse());
  }
};

api::RobotAction displaced(api::RobotAction action, const Offset& offset) {
  if (auto* to = std::get_if<api::MoveTo>(&action)) {
    to->X_RT = offset.sent(to->X_RT);
  } else if (auto* through = std::get_if<api::MoveThroughTo>(&action)) {
    for (api::Waypoint& point : through->waypoints) point.X_RT = offset.sent(point.X_RT);
  } else if (auto* screw = std::get_if<api::MoveScrew>(&action)) {
    if (screw->start) screw->start->X_RT = offset.sent(screw->start->X_RT);
    if (screw->axis_point_R) screw->axis_point_R = offset.before * *screw->axis_point_R;
  }
  return action;
}

/// For the operator's message: what touches what.
std::string describe_contact(const robot::ArmModel& model, const api::CellDescription& cell,
                             std::span<const physics::ArmForce> forces, int held_body) {
  const physics::ArmForce* force = largest(forces, held_body);
  if (!force) return "";
  const auto& link = model.links[static_cast<std::size_t>(force->link)].name;
  char text[96];
  if (force->partner_link >= 0) {
    std::snprintf(text, sizeof text, " link %d with %.0f N", force->partner_link,
                  force->f_W.norm());
  } else {
    std::snprintf(text, sizeof text, " with %.0f N", force->f_W.norm());
  }
  return " (" + (force->on_gripper ? std::string("the gripper") : link) + " touches " +
         api::contact_name(cell, force->partner) + text + ")";
}

}  // namespace

SimulatedRobot::SimulatedRobot(const scene::Scene& scene, std::size_t index,
                               const robot::ArmModel& model, robot::PlanPrefetcher* prefetcher)
    : scene_(scene.robots[index]),
      tools_(scene::tools_of(scene)),
      start_tool_(scene::tools_at_start(scene)[index]),
      X_WB_(scene_.X_WB.isometry()),
      X_WR_(X_WB_ * scene_.X_BR.isometry()),
      tool_setups_(tool_setups_of(scene_, tools_)),
      payload_open_(changer_payload(scene_)),
      arm_(model,
           start_tool_ < 0 ? payload_open_
                           : tool_setups_[static_cast<std::size_t>(start_tool_)].payload,
           gravity_in_base(scene_, scene.physics), home_of(scene_, model), scene.physics.step_s),
      ik_(ik_of(scene_, model)),
      controller_(
          setup_of(scene_, model, ik_, scene.physics, tool_setups_, start_tool_, prefetcher)),
      step_size_(std::llround(scene.physics.step_s * 1e9)),
      X_WL_(model.links.size()) {
  for (const scene::Tool& tool : tools_) X_FT_.push_back(frame_of(tool, scene_));
  guard_input_.action.description.reserve(kDescriptionCapacity);
  update_link_poses();
  state_.X_WM = X_WL_.back();
  state_.tool = start_tool_;
}

void SimulatedRobot::apply(api::Ticket ticket, const api::RobotCommand& command) {
  const api::RobotAction& action = command.action;
  if (!state_.faults.out_of_order.empty()) {
    return controller_.refuse(ticket, action, out_of_order());
  }
  const bool init = std::holds_alternative<api::InitRobot>(action);
  if (init && !controller_.retreating()) arm_.relax();
  if (const auto* set = std::get_if<api::SetGripperForce>(&action)) {
    state_.pressure = std::min(1.0, set->force_n / full_force_n());
  }
  if (state_.faults.has_offset()) {
    controller_.apply(ticket, displaced(action, Offset(state_.faults)), arm_.q());
  } else {
    controller_.apply(ticket, action, arm_.q());
  }
  // The guards of a motion that goes on, unless the command beside it has its own.
  if (!command.guards.empty()) {
    state_.guards.begin(ticket, command.guards);
  } else if (!api::leaves_motion(action)) {
    state_.guards.forget();
  }
}

std::string SimulatedRobot::out_of_order() const {
  return "Out of order: " + state_.faults.out_of_order + "; once that is over, send InitCanon";
}

void SimulatedRobot::set_faults(const RobotFaults& faults) {
  const bool stops = !faults.out_of_order.empty() && state_.faults.out_of_order.empty();
  const bool slows = faults.speed != state_.faults.speed;
  state_.faults = faults;
  arm_.set_torque_share(faults.torque);
  const auto any = [](const auto& values) {
    return std::any_of(values.begin(), values.end(), [](double value) { return value != 0; });
  };
  state_.bent = state_.bent || any(faults.backlash_rad) || any(faults.encoder_bias_rad);
  if (slows) controller_.slow_down(faults.speed);
  if (stops) controller_.shut_down(out_of_order(), faults.brakes_on_path);
}

void SimulatedRobot::trip() {
  if (controller_.stopped_by_protection()) return;
  controller_.protective_stop("Protective stop: tripped; send InitCanon to go on");
}

/// A link follows its encoder at the ends of the joint's play only, and is off by the encoder's
/// error.
void SimulatedRobot::bend_links() {
  if (!state_.bent) return;
  const robot::JointVector& q = arm_.q();
  if (state_.q_before.size() == 0) state_.q_before = q;
  const double most = kBendSpeed * seconds(step_size_);
  bool bent = false;
  for (int i = 0; i < arm_.model().dof(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    double& half = state_.half_width_rad[at];
    half = towards(half, 0.5 * state_.faults.backlash_rad[at], most);
    double& play = state_.play_rad[at];
    play = std::clamp(play - (q(i) - state_.q_before(i)), -half, half);
    double& bias = state_.bias_rad[at];
    bias = towards(bias, state_.faults.encoder_bias_rad[at], most);
    bent = bent || half != 0 || bias != 0 || state_.faults.backlash_rad[at] != 0 ||
           state_.faults.encoder_bias_rad[at] != 0;
  }
  state_.q_before = q;
  state_.bent = bent;
  if (!bent) state_.q_before.resize(0);
}

void SimulatedRobot::step(const physics::GripperState& gripper,
                          std::span<const physics::ArmForce> forces,
                          const api::CellDescription& cell, std::span<const LooseTool> loose) {
  check_guards(gripper, forces);
  // Contact torques of the last step, then the controller's reference for this one.
  const ExternalTorque tau = external_torque(forces);
  const robot::JointVector& reference = controller_.step({.gripper_settled = gripper.settled,
                                                          .tool_at_flange = tool_at_flange(loose),
                                                          .external_nm = tau.all,
                                                          .q_actual = arm_.q()});
  if (controller_.tool() != state_.tool) couple(loose);
  // The servo.
  arm_.set_applied_torque(controller_.applied_torque());
  arm_.set_braked(controller_.braked());
  arm_.step(reference, tau.all, tau.load);
  state_.now += step_size_;
  stop_if_tripped(gripper, forces, cell);
  finish_guards();
  bend_links();
  update_link_poses();
  move_mount();
}

/// The tool changer has locked or released a tool.
void SimulatedRobot::couple(std::span<const LooseTool> loose) {
  state_.tool = controller_.tool();
  state_.pull_steps = state_.tool >= 0 ? kPullSteps : 0;
  arm_.set_payload(payload());
  for (const LooseTool& tool : loose) {
    if (tool.tool == state_.tool) state_.X_WM = mount_of(tool);
  }
}

/// Where this flange's mount would be with the tool in its place.
Eigen::Isometry3d SimulatedRobot::mount_of(const LooseTool& loose) const {
  return loose.X_WT * X_FT_[static_cast<std::size_t>(loose.tool)].inverse();
}

/// The nearest whose coupling is within the capture range.
int SimulatedRobot::tool_at_flange(std::span<const LooseTool> loose) const {
  int nearest = -1;
  double least = scene_.changer.capture_m;
  const Eigen::Isometry3d X_FQ = scene::coupling_of(scene_).isometry();
  const Eigen::Isometry3d X_QW = (X_WL_.back() * X_FQ).inverse();
  for (const LooseTool& tool : loose) {
    const Eigen::Isometry3d X_TQ =
        tools_[static_cast<std::size_t>(tool.tool)].X_QT.isometry().inverse();
    const Eigen::Isometry3d off = X_QW * tool.X_WT * X_TQ;
    const double distance = off.translation().norm();
    if (distance > least || Eigen::AngleAxisd(off.linear()).angle() > scene_.changer.capture_rad) {
      continue;
    }
    least = distance;
    nearest = tool.tool;
  }
  return nearest;
}

const robot::Payload& SimulatedRobot::payload() const {
  return state_.tool < 0 ? payload_open_
                         : tool_setups_[static_cast<std::size_t>(state_.tool)].payload;
}

/// Of each finger of the tool that is on, at the supply's full pressure; of the first one
/// otherwise.
double SimulatedRobot::full_force_n() const {
  return state_.tool < 0 ? scene_.gripper.force_n
                         : tools_[static_cast<std::size_t>(state_.tool)].gripper.force_n;
}

double SimulatedRobot::gripper_force_n() const {
  return state_.faults.grip_force * set_gripper_force_n();
}

double SimulatedRobot::set_gripper_force_n() const { return state_.pressure * full_force_n(); }

/// A tool is drawn to the flange in equal steps.
void SimulatedRobot::move_mount() {
  const Eigen::Isometry3d& X_WF = X_WL_.back();
  if (state_.pull_steps == 0) {
    state_.X_WM = X_WF;
    return;
  }
  const double share = 1.0 / state_.pull_steps--;
  const Eigen::Quaterniond from(state_.X_WM.linear()), to(X_WF.linear());
  state_.X_WM.translation() += share * (X_WF.translation() - state_.X_WM.translation());
  state_.X_WM.linear() = from.slerp(share, to).toRotationMatrix();
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

/// Against the state at the end of the last step.
void SimulatedRobot::check_guards(const physics::GripperState& gripper,
                                  std::span<const physics::ArmForce> forces) {
  if (!state_.guards.active()) return;
  write(gripper, forces, guard_input_);
  const auto triggered = state_.guards.check(guard_input_, state_.now);
  if (!triggered) return;
  const api::ActionStatus& status = controller_.status();
  // A guard of a command that is over stops the motion but ends nothing.
  const bool current =
      status.ticket == state_.guards.state().ticket && status.state == api::ActionState::kWorking;
  const api::Guard& guard = state_.guards.guard(*triggered);
  const std::string what = "Guard " + guard.label + " triggered at " +
                           number(state_.guards.state().trigger_value) + ", limit " +
                           number(guard.value);
  controller_.stop_by_guard(current, what);
  if (guard.error_on_trigger) controller_.fail(what + "; send InitCanon to go on");
}

/// After the controller's step, so that a command whose guard misses its trigger never shows done.
void SimulatedRobot::finish_guards() {
  if (state_.guards.stopping() && !controller_.moving()) state_.guards.at_rest(state_.now);
  if (!state_.guards.active()) return;
  const api::ActionStatus& status = controller_.status();
  if (status.state == api::ActionState::kError) return state_.guards.end();
  if (controller_.moving() || status.state != api::ActionState::kDone) return;
  state_.guards.end();
  const api::Guard* unmet = state_.guards.unmet();
  if (unmet == nullptr) return;
  controller_.fail("Guard " + unmet->label + ": required trigger not seen, limit " +
                   number(unmet->value) + "; send InitCanon to go on");
}

SimulatedRobot::ExternalTorque SimulatedRobot::external_torque(
    std::span<const physics::ArmForce> forces) const {
  ExternalTorque tau;
  tau.all = tau.load = robot::JointVector::Zero(arm_.model().dof());
  for (const auto& force : forces) {
    if (force.relayed || (force.on_gripper && state_.tool < 0)) continue;
    // tau = J^T f.
    const auto& X_WL = X_WL_[static_cast<std::size_t>(force.link)];
    const auto J =
        robot::point_jacobian(arm_.model(), arm_.q(), force.link, X_WL.inverse() * force.p_W);
    const robot::JointVector part =
        J.topRows<3>().transpose() * (X_WB_.linear().transpose() * force.f_W);
    tau.all += part;
    const bool body = force.partner.kind == api::ContactSide::Kind::kBody;
    if (force.on_gripper && body) tau.load += part;
  }
  return tau;
}

void SimulatedRobot::stop_if_tripped(const physics::GripperState& gripper,
                                     std::span<const physics::ArmForce> forces,
                                     const api::CellDescription& cell) {
  if (controller_.retreating()) return arm_.forget_trip();  // still in contact
  // Out of order and held by its brakes, it does not back off.
  if (!state_.faults.out_of_order.empty() && controller_.braked()) return arm_.forget_trip();
  // A robot that still brakes for the light curtain may yet collide.
  if (controller_.stopped_by_protection() && !controller_.moving()) return;
  std::string reason;
  if (!arm_.trip_reason().empty()) {
    reason = arm_.trip_reason();
  } else if (state_.tool >= 0 && gripper.palm_deflection_m > kMaxPalmDeflection_m) {
    char text[96];
    std::snprintf(text, sizeof text, "gripper mount deflected by %.1f mm, limit %.1f mm",
                  gripper.palm_deflection_m * 1e3, kMaxPalmDeflection_m * 1e3);
    reason = text;
  } else {
    return;
  }
  reason = "Protective stop: " + reason +
           describe_contact(arm_.model(), cell, forces, gripper.held_body) +
           "; the arm backs off by itself; send InitCanon, then move away";
  arm_.relax();
  controller_.protective_stop(reason, arm_.q());
}

void SimulatedRobot::stop_for_light_curtain() {
  if (controller_.stopped_by_protection()) return;
  controller_.protective_stop(
      "Protective stop: the light curtain is broken; clear it, then send InitCanon");
}

void SimulatedRobot::update_link_poses() {
  if (state_.bent) {
    robot::JointVector q = arm_.q();
    for (int i = 0; i < arm_.model().dof(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      q(i) += state_.play_rad[at] - state_.bias_rad[at];
    }
    robot::link_poses(arm_.model(), q, X_WL_);
  } else {
    robot::link_poses(arm_.model(), arm_.q(), X_WL_);
  }
  for (auto& X : X_WL_) X = X_WB_ * X;
}

api::RobotDescription SimulatedRobot::description() const {
  api::RobotDescription out;
  out.name = scene_.name;
  out.model = arm_.model().name;
  for (const auto& joint : arm_.model().joints) {
    out.joints.push_back({.name = joint.name,
                          .lower_rad = joint.lower_rad,
                          .upper_rad = joint.upper_rad,
                          .max_speed_rad_s = joint.max_speed_rad_s,
                          .max_torque_nm = joint.max_torque_nm});
  }
  for (const auto& link : arm_.model().links) out.links.push_back(link.name);
  const Eigen::Isometry3d X_RB = scene_.X_BR.isometry().inverse();
  const auto& joints = arm_.model().joints;
  // Reach: a box about the point on axis 1 at the height of axis 2.
  const Eigen::Vector3d centre_B(joints[0].X_PJ.translation() +
                                 joints[1].X_PJ.translation().z() * Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(
      reach_of(arm_.model(), scene_.tool_point_F.value_or(scene_.X_FT).isometry()));
  out.reach_min_R = X_RB * centre_B - reach;
  out.reach_max_R = X_RB * centre_B + reach;
  out.X_WB = scene_.X_WB;
  out.X_BR = scene_.X_BR;
  out.X_RV = scene_.vision.X_RV;
  out.X_FT = scene_.X_FT;
  out.tool_point_F = scene_.tool_point_F;
  out.wire_joints = scene_.crcl_joints;
  out.X_FQ = scene::coupling_of(scene_);
  out.gripper = describe_gripper(scene_.gripper);
  out.gripper.names = scene_.gripper_names;
  out.max_trans_speed_m_s = scene_.max_trans_speed_m_s;
  out.max_trans_accel_m_s2 = scene_.max_trans_accel_m_s2;
  out.max_rot_speed_rad_s = scene_.max_rot_speed_rad_s;
  out.max_rot_accel_rad_s2 = scene_.max_rot_accel_rad_s2;
  return out;
}

void SimulatedRobot::write(const physics::GripperState& gripper,
                           std::span<const physics::ArmForce> forces,
                           api::RobotSnapshot& out) const {
  const auto& model = arm_.model();
  // Pose and velocity of the tool.
  const Eigen::Isometry3d X_FT = controller_.X_FT();
  const Eigen::Isometry3d X_WT = X_WL_.back() * X_FT;
  // Through the base, not the world: a pose that a client compares must not carry the cell's
  // layout.
  const Eigen::Isometry3d X_BF = robot::flange_pose(model, arm_.q());
  const Eigen::Isometry3d X_RB = scene_.X_BR.isometry().inverse();
  out.X_WT = Pose::from(X_WT);
  out.X_RT = Pose::from(X_RB * X_BF * X_FT);
  if (state_.faults.has_offset()) out.X_RT = Offset(state_.faults).reported(out.X_RT);
  const auto J = robot::point_jacobian(model, arm_.q(), model.dof(), X_FT.translation());
  for (int i = 0; i < model.dof(); ++i) {
    out.joints[static_cast<std::size_t>(i)] = {.position_rad = arm_.q()[i],
                                               .velocity_rad_s = arm_.qd()[i],
                                               .torque_nm = arm_.torque()[i],
                                               .tool_lever_m = J.col(i).head<3>().norm()};
  }
  const Eigen::Matrix<double, 6, 1> twist_B = J * arm_.qd();
  out.v_RT = X_RB.linear() * twist_B.head<3>();
  out.omega_RT = X_RB.linear() * twist_B.tail<3>();
  // Contact wrench on flange and tool, about the tool point.
  out.force_T_R.setZero();
  out.torque_T_R.setZero();
  const Eigen::Matrix3d R_RW = X_WR_.linear().transpose();
  for (const auto& force : forces) {
    if (force.link != model.dof() || force.relayed) continue;
    if (force.on_gripper && state_.tool < 0) continue;
    out.force_T_R += R_RW * force.f_W;
    out.torque_T_R += R_RW * (force.p_W - X_WT.translation()).cross(force.f_W);
  }
  out.gripper = {.setting = controller_.gripper_setting(),
                 .separation_m = gripper.separation_m,
                 .travel_m = gripper.travel_m,
                 .force_n = gripper.force_n,
                 .holding = gripper.holding,
                 .held_body = gripper.held_body,
                 .palm_deflection_m = gripper.palm_deflection_m,
                 .max_force_n = set_gripper_force_n(),
                 .vacuum_pa = gripper.vacuum_pa};
  out.trans_speed = controller_.limit(api::MotionLimit::kTransSpeed);
  out.trans_accel = controller_.limit(api::MotionLimit::kTransAccel);
  out.rot_speed = controller_.limit(api::MotionLimit::kRotSpeed);
  out.rot_accel = controller_.limit(api::MotionLimit::kRotAccel);
  out.override_fraction = controller_.override_fraction();
  out.tool_mounted = state_.tool >= 0;
  out.tool = state_.tool;
  out.action = controller_.status();
  out.X_RG = controller_.X_RG();
  if (out.X_RG && state_.faults.has_offset()) {
    out.X_RG = Offset(state_.faults).reported(*out.X_RG);
  }
  out.initialized = controller_.initialized();
  out.protective_stop = controller_.stopped_by_protection();
  out.moving = controller_.moving();
  out.drives_on = controller_.drives_on();
  out.posture = ik_->posture_of(arm_.q());
  out.light_curtain_broken = state_.curtain_broken;
  out.guards = state_.guards.state();
}

}  // namespace aprsim::world
