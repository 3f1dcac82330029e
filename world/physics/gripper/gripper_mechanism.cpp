#include "world/physics/gripper/gripper_mechanism.hpp"

#include <algorithm>
#include <cmath>

#include "world/scene/model/part_shapes.hpp"

namespace aprsim::physics {
namespace {

constexpr double kStopZone = 2e-4;   // [m] next to a stop
constexpr double kLeverShare = 0.2;  // of a finger's mass

/// Bounds that meet nothing.
const Aabb kNowhere{Eigen::Vector3d::Constant(1e30), Eigen::Vector3d::Constant(-1e30)};

dMass box_mass(double kg, const Eigen::Vector3d& size) {
  dMass m;
  dMassSetBoxTotal(&m, kg, size.x(), size.y(), size.z());
  return m;
}

}  // namespace

// ---- construction

GripperMechanism::GripperMechanism(const scene::Gripper& gripper, dWorldID world,
                                   const Eigen::Isometry3d& X_WF, double step_s)
    : settings_(gripper), step_s_(step_s) {
  dVector3 gravity;
  dWorldGetGravity(world, gravity);
  gravity_W_ = ode::vector(gravity);
  joints_.fingers = !settings_.cup;
  joints_.linkage = joints_.fingers && settings_.law == scene::GripperLaw::kLinkage;
  joints_.closed_travel_m = 0.5 * (settings_.gap_open_m - settings_.gap_closed_m);
  now_.X_WT = now_.X_WT_next = X_WF;
  now_.law.air = {0, full_pressure(settings_)};
  pad_ = pad_of(settings_);
  if (settings_.cup) cup_solid_ = scene::cup_solid(settings_);
  now_.report.separation_m = settings_.gap_open_m;
  now_.report.X_WT = Pose::from(now_.X_WT);
  make_parts(world);
  make_mount(world);
  for (int i = 0; joints_.fingers && i < 2; ++i) make_slider(world, i);
  if (joints_.linkage) make_linkage(world);
  move_with_mount();
  enable(false);
}

/// Their order is also that in which ODE's solvers see them.
void GripperMechanism::make_parts(dWorldID world) {
  const scene::Block palm = scene::palm_of(settings_);
  now_.parts[0].size = palm.size;
  now_.parts[0].X_TS.translation() = palm.centre;
  const auto fingers = scene::fingers_of(settings_, settings_.gap_open_m);
  for (std::size_t i = 0; i < 2; ++i) {
    now_.parts[i + 1].size = fingers[i].size;
    now_.parts[i + 1].X_TS.translation() = fingers[i].centre;
  }
  if (settings_.cup) {
    const scene::Block cup = scene::cup_of(settings_);
    now_.parts[1].size = cup.size;
    now_.parts[1].X_TS.translation() = cup.centre;
    now_.suction.full_force_n = suction_force(*settings_.cup, settings_.cup->max_vacuum_pa, 1);
  }
  const double lever_kg = kLeverShare * settings_.finger_mass_kg;
  const double travel = joints_.closed_travel_m;
  now_.parts[3].size = Eigen::Vector3d(4 * travel, 0.25 * travel, 0.25 * travel);
  now_.parts[3].X_TS.translation().z() = -0.5 * settings_.pad_height_m;

  const std::array<double, 4> kg = {settings_.palm_mass_kg, settings_.finger_mass_kg,
                                    settings_.finger_mass_kg, lever_kg};
  for (std::size_t i = 0; i < bodies().size(); ++i) {
    auto& part = now_.parts[i];
    bodies_[i].reset(dBodyCreate(world));
    dBodyID body = joints_.bodies[i] = bodies_[i].get();
    const dMass m = box_mass(kg[i], part.size);
    dBodySetMass(body, &m);
    // Weight and inertia of the gripper are the arm's business: see the class.
    dBodySetGravityMode(body, 0);
    dBodySetGyroscopicMode(body, 0);
    dBodySetFiniteRotationMode(body, 1);
    part.X_WS = now_.X_WT * part.X_TS;
    part.bounds = aabb_of_box(part.size, part.X_WS);
    ode::set_rotation(body, part.X_WS.linear());
    ode::set_position(body, part.X_WS.translation());
  }
  // The carriage sits at the palm's centre, so that the mount sees no lever arm.
  carriage_.reset(dBodyCreate(world));
  dBodySetKinematic(carriage_.get());
  dBodySetFiniteRotationMode(carriage_.get(), 1);
  joints_.carriage = carriage_.get();
  place_carriage();
}

/// Palm on carriage.
void GripperMechanism::make_mount(dWorldID world) {
  mount_.reset(dJointCreateFixed(world, nullptr));
  dJointAttach(mount_.get(), joints_.bodies[0], carriage_.get());
  dJointSetFixed(mount_.get());
  set_step_s(step_s_);
}

/// The mount is the implicit spring and damper of ODE's manual, section "How to use ERP and CFM".
void GripperMechanism::set_step_s(double step_s) {
  step_s_ = step_s;
  const double hk = step_s_ * settings_.palm_stiffness_n_m;
  joints_.mount_erp = hk / (hk + settings_.palm_damping_ns_m);
  joints_.mount_cfm = 1 / (hk + settings_.palm_damping_ns_m);
}

/// Finger on palm, positive travel closing.
void GripperMechanism::make_slider(dWorldID world, int i) {
  const auto index = static_cast<std::size_t>(i);
  const Eigen::Vector3d axis = closing_W(i);
  joints_.rail[index] = now_.parts[index + 1].X_TS.translation() - now_.parts[0].X_TS.translation();
  auto& slider = sliders_[index];
  slider.reset(dJointCreateSlider(world, nullptr));
  dJointAttach(slider.get(), joints_.bodies[index + 1], joints_.bodies[0]);
  dJointSetSliderAxis(slider.get(), axis.x(), axis.y(), axis.z());
  dJointSetSliderParam(slider.get(), dParamCFM, GripperConstraints::kPistonCfm);
  dJointSetSliderParam(slider.get(), dParamStopCFM, GripperConstraints::kStopCfm);
}

/// A lever on the palm, turning about the tool's axis, with a rod to each finger.
void GripperMechanism::make_linkage(dWorldID world) {
  const Eigen::Vector3d pivot = now_.parts[3].X_WS.translation();
  const Eigen::Vector3d axis = now_.X_WT.linear().col(2);
  hinge_.reset(dJointCreateHinge(world, nullptr));
  dJointAttach(hinge_.get(), joints_.bodies[3], joints_.bodies[0]);
  dJointSetHingeAnchor(hinge_.get(), pivot.x(), pivot.y(), pivot.z());
  dJointSetHingeAxis(hinge_.get(), axis.x(), axis.y(), axis.z());
  // Lever ends and rods are mirror images through the pivot, so equal travels are exact.
  const double arm = std::max(0.02, 2 * joints_.closed_travel_m);
  const double rod_length = GripperConstraints::kRodLength;
  joints_.pivot = now_.parts[3].X_TS.translation() - now_.parts[0].X_TS.translation();
  for (std::size_t i = 0; i < 2; ++i) {
    const double side = i == 0 ? 1 : -1;
    joints_.rod_on_lever[i] = side * arm * Eigen::Vector3d::UnitX();
    joints_.rod_on_finger[i] = joints_.pivot + joints_.rod_on_lever[i] +
                               side * rod_length * Eigen::Vector3d::UnitY() - joints_.rail[i];
    const Eigen::Vector3d end = pivot + side * arm * now_.X_WT.linear().col(0);
    const Eigen::Vector3d on_finger = end + side * rod_length * now_.X_WT.linear().col(1);
    auto& rod = rods_[i];
    rod.reset(dJointCreateDBall(world, nullptr));
    dJointAttach(rod.get(), joints_.bodies[i + 1], joints_.bodies[3]);
    dJointSetDBallAnchor1(rod.get(), on_finger.x(), on_finger.y(), on_finger.z());
    dJointSetDBallAnchor2(rod.get(), end.x(), end.y(), end.z());
  }
}

// ---- on a flange, or not

void GripperMechanism::take(const Eigen::Isometry3d& X_WF, const Eigen::Isometry3d& X_FT) {
  now_.mounted = true;
  now_.X_FT = X_FT;
  now_.X_WT = now_.X_WT_next = X_WF * X_FT;
  now_.delta.setIdentity();
  now_.omega.setZero();
  now_.idle = true;
  now_.report.X_WT = Pose::from(now_.X_WT);
  now_.report.palm_deflection_m = 0;
  enable(true);
  move_with_mount();
  if (settings_.cup) return closing() ? wake() : void();
  const bool steady = settings_.drive == scene::GripperDrive::kServo ||
                      air_is_steady(settings_, closing(), now_.law.air);
  for (const FingerMotion& motion : now_.motion) {
    if (!steady || motion.travel_m != stop_travel()) wake();
  }
}

void GripperMechanism::leave() {
  auto& lever = now_.parts[3];
  if (!now_.idle) lever.X_TS = now_.X_WT.inverse() * lever.X_WS;
  now_.mounted = false;
  now_.idle = true;
  for (FingerMotion& motion : now_.motion) motion.rate_m_s = 0;
  now_.law = {};
  now_.law.air = {0, 0};
  draw_nothing();
  now_.grasp.restart(now_.report);
  now_.report.force_n = {};
  now_.report.holding = false;
  now_.report.held_body = -1;
  now_.report.settled = true;
  now_.report.palm_deflection_m = 0;
  move_with_mount();
  enable(false);
}

/// For ODE's solvers.
void GripperMechanism::enable(bool on) {
  for (dBodyID body : bodies()) on ? dBodyEnable(body) : dBodyDisable(body);
  on ? dBodyEnable(carriage_.get()) : dBodyDisable(carriage_.get());
}

// ---- a step

GripperMechanism::State GripperMechanism::save() const {
  State state = now_;
  state.force_n = settings_.force_n;
  for (std::size_t i = 0; i < bodies().size(); ++i) ode::save(joints_.bodies[i], state.bodies[i]);
  return state;
}

void GripperMechanism::restore(const State& state) {
  now_ = state;
  settings_.force_n = state.force_n;
  for (std::size_t i = 0; i < bodies().size(); ++i)
    ode::restore(joints_.bodies[i], state.bodies[i]);
  place_carriage();
  enable(now_.mounted);
}

void GripperMechanism::save(Solved& to) const {
  for (std::size_t i = 0; i < bodies().size(); ++i) ode::save(joints_.bodies[i], to.bodies[i]);
  to.forces = now_.forces;
}

void GripperMechanism::restore(const Solved& from) {
  for (std::size_t i = 0; i < bodies().size(); ++i) ode::restore(joints_.bodies[i], from.bodies[i]);
  now_.forces = from.forces;
}

void GripperMechanism::command(double setting) {
  if (!now_.mounted) return;  // no air
  const bool servo = settings_.drive == scene::GripperDrive::kServo;
  const double reached = servo ? setting : setting > 0.5 ? 1 : 0;  // a piston knows two
  if (reached == now_.setting) return;
  now_.setting = reached;
  now_.law.mimic = {};
  now_.grasp.restart(now_.report);
  wake();
}

void GripperMechanism::set_force(double force_n) {
  if (!now_.mounted || force_n == settings_.force_n) return;
  settings_.force_n = force_n;
  wake();
}

void GripperMechanism::set_wear(const GripperWear& wear) {
  if (wear == now_.wear) return;
  now_.wear = wear;
  if (now_.mounted) wake();
}

void GripperMechanism::begin_step(const Eigen::Isometry3d& X_WF_next) {
  now_.X_WT_next = X_WF_next * now_.X_FT;
  now_.delta = now_.X_WT_next * now_.X_WT.inverse();
  const Eigen::AngleAxisd turn(now_.delta.linear());
  const Eigen::Vector3d omega_before = now_.omega;
  now_.omega = turn.angle() / step_s_ * turn.axis();
  if (now_.idle) return;
  // Velocities relative to the carriage turn with it; its own change is the arm's business, but for
  // the fingers along their rails, where inertia and weight load the pistons.
  for (std::size_t i = 0; i < bodies().size(); ++i) {
    auto& part = now_.parts[i];
    const Eigen::Vector3d v = ode::vector(dBodyGetLinearVel(joints_.bodies[i]));
    const Eigen::Vector3d w = ode::vector(dBodyGetAngularVel(joints_.bodies[i]));
    const Eigen::Vector3d u = carried_velocity(part.X_WS.translation());
    const Eigen::Vector3d before = now_.delta.linear() * part.carried_v;
    Eigen::Vector3d next = u + now_.delta.linear() * v - before;
    if (joints_.fingers && (i == 1 || i == 2)) {
      const Eigen::Vector3d axis = closing_W(static_cast<int>(i) - 1);
      next += axis.dot(step_s_ * gravity_W_ - (u - before)) * axis;
    }
    ode::set_velocity(joints_.bodies[i], next,
                      now_.omega + now_.delta.linear() * (w - omega_before));
    part.carried_v = u;
  }
  place_carriage();
  set_drives();
}

/// From the fingers' motion, by the law, to the sliders' motors and end stops.
void GripperMechanism::set_drives() {
  if (!joints_.fingers) return;
  for (std::size_t i = 0; i < 2; ++i) {
    now_.motion[i] = {dJointGetSliderPosition(sliders_[i].get()),
                      dJointGetSliderPositionRate(sliders_[i].get())};
  }
  now_.drives = settings_.drive == scene::GripperDrive::kServo
                    ? servo_drives(settings_, stop_travel(), now_.motion)
                    : finger_drives(settings_, closing(), now_.motion, joints_.closed_travel_m,
                                    step_s_, now_.law);
  for (std::size_t i = 0; i < 2; ++i) {
    now_.drives[i].speed_m_s *= now_.wear.finger_speed[i];
    dJointID slider = sliders_[i].get();
    dJointSetSliderParam(slider, dParamVel, now_.drives[i].speed_m_s);
    dJointSetSliderParam(slider, dParamFMax, now_.drives[i].piston_n);
    // ODE's motor pushes with all its force, unlimited in speed, in a step that begins at a stop:
    // right against the stop, wrong away from it. So the stop that a finger leaves is removed.
    const double travel = now_.motion[i].travel_m;
    const bool leaves_open = stop_travel() > kStopZone && travel < kStopZone;
    const bool leaves_closed = stop_travel() < joints_.closed_travel_m - kStopZone &&
                               travel > joints_.closed_travel_m - kStopZone;
    dJointSetSliderParam(slider, dParamLoStop, leaves_open ? -dInfinity : 0);
    dJointSetSliderParam(slider, dParamHiStop, leaves_closed ? dInfinity : joints_.closed_travel_m);
  }
}

void GripperMechanism::add_to(ConstraintSystem& system) {
  place_carriage();
  apply_forces();
  GripperConstraints(joints_, step_s_).add_to(system, now_.motion, now_.drives, now_.forces);
}

void GripperMechanism::apply_forces() {
  if (!joints_.fingers) return;
  for (std::size_t i = 0; i < 2; ++i) {
    const double extra_n = now_.drives[i].extra_n;
    if (extra_n != 0) dJointAddSliderForce(sliders_[i].get(), extra_n);
  }
}

/// The carriage's velocity takes it to its next pose in this step.
void GripperMechanism::place_carriage() {
  const Eigen::Isometry3d X_WS = now_.X_WT * now_.parts[0].X_TS;
  ode::set_rotation(carriage_.get(), X_WS.linear());
  ode::set_position(carriage_.get(), X_WS.translation());
  ode::set_velocity(carriage_.get(), carried_velocity(X_WS.translation()), now_.omega);
}

void GripperMechanism::end_step() {
  now_.X_WT = now_.X_WT_next;
  if (now_.idle) {
    move_with_mount();
  } else {
    read_back();
  }
  now_.report.X_WT = Pose::from(now_.parts[0].X_WS * now_.parts[0].X_TS.inverse());
}

/// From ODE to our records.
void GripperMechanism::read_back() {
  for (std::size_t i = 0; i < bodies().size(); ++i) {
    auto& part = now_.parts[i];
    part.X_WS.linear() = ode::matrix(dBodyGetRotation(joints_.bodies[i]));
    part.X_WS.translation() = ode::vector(dBodyGetPosition(joints_.bodies[i]));
    part.bounds = aabb_of_box(part.size, part.X_WS);
  }
  if (settings_.cup) place_cup();
  for (std::size_t i = 0; joints_.fingers && i < 2; ++i) {
    now_.motion[i] = {dJointGetSliderPosition(sliders_[i].get()),
                      dJointGetSliderPositionRate(sliders_[i].get())};
    now_.report.travel_m[i] = now_.motion[i].travel_m;
  }
  now_.report.separation_m =
      settings_.gap_open_m - now_.report.travel_m[0] - now_.report.travel_m[1];
  now_.report.palm_deflection_m =
      (now_.parts[0].X_WS.translation() - (now_.X_WT * now_.parts[0].X_TS).translation()).norm();
}

/// The cup where its palm is.
void GripperMechanism::place_cup() {
  auto& cup = now_.parts[1];
  cup.X_WS = X_WLip() * cup.X_TS;
  cup.bounds = aabb_of_box(cup.size, cup.X_WS);
}

/// Fingers at their travels, the mount undeflected.
Eigen::Isometry3d GripperMechanism::resting_X_TS(std::size_t part) const {
  Eigen::Isometry3d X_TS = now_.parts[part].X_TS;
  if (part == 1) X_TS.translation().y() -= now_.report.travel_m[0];
  if (part == 2) X_TS.translation().y() += now_.report.travel_m[1];
  return X_TS;
}

/// Idle: the parts move with the mount as one.
void GripperMechanism::move_with_mount() {
  for (std::size_t i = 0; i < 3; ++i) {
    now_.parts[i].X_WS = now_.X_WT * resting_X_TS(i);
    const bool there = now_.mounted && !(settings_.cup && i == 2);
    now_.parts[i].bounds = there ? aabb_of_box(now_.parts[i].size, now_.parts[i].X_WS) : kNowhere;
  }
}

void GripperMechanism::wake() {
  if (!now_.mounted) return;
  now_.grasp.stay_awake();
  if (!now_.idle) return;
  now_.idle = false;
  // Bodies where the parts are, moving with the mount.
  for (std::size_t i = 0; i < bodies().size(); ++i) {
    auto& part = now_.parts[i];
    if (i == 3) part.X_WS = now_.X_WT * part.X_TS;
    ode::set_rotation(joints_.bodies[i], part.X_WS.linear());
    ode::set_position(joints_.bodies[i], part.X_WS.translation());
    part.carried_v = carried_velocity(part.X_WS.translation());
    ode::set_velocity(joints_.bodies[i], part.carried_v, now_.omega);
  }
  place_carriage();
}

void GripperMechanism::observe(const PadForces& pads, bool touched) {
  now_.report.force_n = pads.closing_n;
  if (now_.idle) return;
  if (settings_.cup) {
    if (observe_cup(touched)) become_idle();
    return;
  }
  const bool at_full_force = settings_.drive == scene::GripperDrive::kServo ||
                             air_is_steady(settings_, closing(), now_.law.air);
  const bool idle = now_.grasp.observe({.pads = pads,
                                        .motion = now_.motion,
                                        .stop_travel_m = stop_travel(),
                                        .closed_travel_m = joints_.closed_travel_m,
                                        .force_n = settings_.force_n,
                                        .at_full_force = at_full_force,
                                        .touched = touched},
                                       now_.report);
  if (idle) become_idle();
}

/// As of a gripper whose pads press with the suction's force.
bool GripperMechanism::observe_cup(bool touched) {
  const Suction& suction = now_.suction;
  PadForces pads;
  pads.closing_n = {suction.force_n, suction.force_n};
  pads.body = {suction.body, suction.body};
  now_.report.force_n = {suction.force_n, 0};
  return now_.grasp.observe({.pads = pads,
                             .motion = now_.motion,
                             .stop_travel_m = 0,
                             .closed_travel_m = 1,
                             .force_n = suction.full_force_n,
                             .at_full_force = suction.steady,
                             .touched = touched || draws()},
                            now_.report);
}

bool GripperMechanism::draws() const {
  constexpr double kSpent_Pa = 1;
  return settings_.cup && now_.mounted && (closing() || now_.report.vacuum_pa > kSpent_Pa);
}

void GripperMechanism::draw(const LipSeal& seal, int body, double share) {
  constexpr double kSteady = 0.01;  // share of the highest vacuum
  const scene::VacuumCup& cup = *settings_.cup;
  const double end = closing() ? steady_vacuum(cup, seal.leak_m2) : 0;
  now_.report.vacuum_pa = advance_vacuum(cup, closing(), seal, step_s_, now_.report.vacuum_pa);
  Suction& suction = now_.suction;
  suction.steady = std::abs(now_.report.vacuum_pa - end) < kSteady * cup.max_vacuum_pa;
  suction.body = body;
  suction.force_n = suction_force(cup, now_.report.vacuum_pa, share);
  if (!suction.steady) now_.grasp.restart(now_.report);
}

void GripperMechanism::draw_nothing() {
  now_.report.vacuum_pa = 0;
  now_.suction.body = -1;
  now_.suction.force_n = 0;
  now_.suction.steady = true;
}

/// Exactly at the stop and on the mount; the lever, which has no travel of its own, where it is.
void GripperMechanism::become_idle() {
  const double stop = joints_.fingers ? stop_travel() : 0;
  now_.idle = true;
  now_.report.travel_m = {stop, stop};
  now_.report.separation_m = settings_.gap_open_m - 2 * stop;
  now_.report.palm_deflection_m = 0;
  now_.motion = {FingerMotion{stop, 0}, FingerMotion{stop, 0}};
  auto& lever = now_.parts[3];
  lever.X_TS = now_.X_WT.inverse() * lever.X_WS;
  move_with_mount();
}

/// Of the point at p_W, if it moved with the mount.
Eigen::Vector3d GripperMechanism::carried_velocity(const Eigen::Vector3d& p_W) const {
  return (now_.delta * p_W - p_W) / step_s_;
}

Moving GripperMechanism::moving(int i) const {
  const auto& box = part(i);
  Moving out{.p_W = box.X_WS.translation(), .reach_m = 0.5 * box.size.norm()};
  if (now_.idle) {
    out.v_W = carried_velocity(out.p_W);
    out.omega_W = now_.omega;
    return out;
  }
  // A cup is part of the palm.
  dBodyID body = joints_.bodies[joints_.fingers ? static_cast<std::size_t>(i) : 0];
  out.omega_W = ode::vector(dBodyGetAngularVel(body));
  out.v_W = ode::vector(dBodyGetLinearVel(body)) +
            out.omega_W.cross(out.p_W - ode::vector(dBodyGetPosition(body)));
  return out;
}

Eigen::Isometry3d GripperMechanism::X_WD(int finger) const {
  const auto& part = now_.parts[static_cast<std::size_t>(finger) + 1];
  return part.X_WS * pad_in_finger(finger, part.size);
}

Eigen::Vector3d GripperMechanism::closing_W(int finger) const {
  const auto& part = now_.parts[static_cast<std::size_t>(finger) + 1];
  return (finger == 0 ? -1.0 : 1.0) * part.X_WS.linear().col(1);
}

}  // namespace aprsim::physics
