#include "world/physics/gripper/gripper_mechanism.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::physics {
namespace {

constexpr double kStillRate = 2e-3;  // [m/s] below which a finger counts as stopped
constexpr int kStillSteps = 20;      // for as long
constexpr int kHoldSteps = 5;
constexpr int kLostSteps = 3;
constexpr double kHoldShare = 0.05;    // of the piston force that both pads must bear
constexpr double kShortOfStop = 2e-5;  // [m]
constexpr double kStopZone = 2e-4;     // [m] next to a stop
constexpr int kIdleSteps = 50;
constexpr double kIdleDeflection = 2e-6;  // [m]

}  // namespace

GripperMechanism::State GripperMechanism::save() const {
  State state = now_;
  state.force_n = settings_.force_n;
  for (std::size_t i = 0; i < body_count_; ++i) ode::save(bodies_[i], state.bodies[i]);
  return state;
}

void GripperMechanism::restore(const State& state) {
  now_ = state;
  settings_.force_n = state.force_n;
  for (std::size_t i = 0; i < body_count_; ++i) ode::restore(bodies_[i], state.bodies[i]);
  place_carriage();
}

void GripperMechanism::command(double setting) {
  const bool servo = settings_.drive == scene::GripperDrive::kServo;
  const double taken = servo ? setting : setting > 0.5 ? 1 : 0;
  if (taken == now_.setting) return;
  now_.setting = taken;
  now_.law.mimic = {};
  now_.still_steps = 0;
  now_.report.settled = false;
  wake();
}

void GripperMechanism::set_force(double force_n) {
  if (force_n == settings_.force_n) return;
  settings_.force_n = force_n;
  wake();
}

void GripperMechanism::begin_step(const Eigen::Isometry3d& X_WF_next) {
  now_.X_WT_next = X_WF_next * X_FT_;
  now_.delta = now_.X_WT_next * now_.X_WT.inverse();
  const Eigen::AngleAxisd turn(now_.delta.linear());
  const Eigen::Vector3d omega_before = now_.omega;
  now_.omega = turn.angle() / step_s_ * turn.axis();
  if (now_.idle) return;
  for (std::size_t i = 0; i < body_count_; ++i) {
    auto& part = now_.parts[i];
    const Eigen::Vector3d v = ode::vector(dBodyGetLinearVel(bodies_[i]));
    const Eigen::Vector3d w = ode::vector(dBodyGetAngularVel(bodies_[i]));
    const Eigen::Vector3d u = carried_velocity(part.X_WS.translation());
    ode::set_velocity(bodies_[i], u + now_.delta.linear() * (v - part.carried_v),
                      now_.omega + now_.delta.linear() * (w - omega_before));
    part.carried_v = u;
  }
  place_carriage();
  drive();
}

void GripperMechanism::drive() {
  for (std::size_t i = 0; i < 2; ++i) {
    now_.motion[i] = {dJointGetSliderPosition(sliders_[i].get()),
                      dJointGetSliderPositionRate(sliders_[i].get())};
  }
  now_.drives = settings_.drive == scene::GripperDrive::kServo
                    ? servo_drives(settings_, stop(), now_.motion)
                    : finger_drives(settings_, closing(), now_.motion, end_m_, step_s_, now_.law);
  for (std::size_t i = 0; i < 2; ++i) {
    dJointID slider = sliders_[i].get();
    dJointSetSliderParam(slider, dParamVel, now_.drives[i].speed_m_s);
    dJointSetSliderParam(slider, dParamFMax, now_.drives[i].piston_n);
    // ODE's motor pushes with all its force, unlimited in speed, in a step that begins at a stop:
    // right against the stop, wrong away from it. The stop that a finger leaves is taken away.
    const double travel = now_.motion[i].travel_m;
    const bool leaves_open = stop() > kStopZone && travel < kStopZone;
    const bool leaves_closed = stop() < end_m_ - kStopZone && travel > end_m_ - kStopZone;
    dJointSetSliderParam(slider, dParamLoStop, leaves_open ? -dInfinity : 0);
    dJointSetSliderParam(slider, dParamHiStop, leaves_closed ? dInfinity : end_m_);
  }
}

void GripperMechanism::apply_forces() {
  for (std::size_t i = 0; i < 2; ++i) {
    if (now_.drives[i].extra_n != 0)
      dJointAddSliderForce(sliders_[i].get(), now_.drives[i].extra_n);
  }
}

void GripperMechanism::place_carriage() {
  const Eigen::Isometry3d X_WS = now_.X_WT * now_.parts[0].X_TS;
  ode::set_rotation(carriage_.get(), X_WS.linear());
  ode::set_position(carriage_.get(), X_WS.translation());
  ode::set_velocity(carriage_.get(), carried_velocity(X_WS.translation()), now_.omega);
}

void GripperMechanism::end_step() {
  now_.X_WT = now_.X_WT_next;
  if (now_.idle) {
    follow();
  } else {
    read_back();
  }
  now_.report.X_WT = Pose::from(now_.parts[0].X_WS * now_.parts[0].X_TS.inverse());
}

void GripperMechanism::read_back() {
  for (std::size_t i = 0; i < body_count_; ++i) {
    auto& part = now_.parts[i];
    part.X_WS.linear() = ode::matrix(dBodyGetRotation(bodies_[i]));
    part.X_WS.translation() = ode::vector(dBodyGetPosition(bodies_[i]));
    part.bounds = bounds_of_box(part.size, part.X_WS);
  }
  for (std::size_t i = 0; i < 2; ++i) {
    now_.motion[i] = {dJointGetSliderPosition(sliders_[i].get()),
                      dJointGetSliderPositionRate(sliders_[i].get())};
    now_.report.travel_m[i] = now_.motion[i].travel_m;
  }
  now_.report.separation_m =
      settings_.gap_open_m - now_.report.travel_m[0] - now_.report.travel_m[1];
  now_.report.palm_deflection_m =
      (now_.parts[0].X_WS.translation() - (now_.X_WT * now_.parts[0].X_TS).translation()).norm();
}

Eigen::Isometry3d GripperMechanism::resting_X_TS(std::size_t part) const {
  Eigen::Isometry3d X_TS = now_.parts[part].X_TS;
  if (part == 1) X_TS.translation().y() -= now_.report.travel_m[0];
  if (part == 2) X_TS.translation().y() += now_.report.travel_m[1];
  return X_TS;
}

void GripperMechanism::follow() {
  for (std::size_t i = 0; i < 3; ++i) {
    now_.parts[i].X_WS = now_.X_WT * resting_X_TS(i);
    now_.parts[i].bounds = bounds_of_box(now_.parts[i].size, now_.parts[i].X_WS);
  }
}

void GripperMechanism::wake() {
  now_.free_steps = 0;
  if (!now_.idle) return;
  now_.idle = false;
  for (std::size_t i = 0; i < body_count_; ++i) {
    auto& part = now_.parts[i];
    if (i == 3) part.X_WS = now_.X_WT * part.X_TS;
    ode::set_rotation(bodies_[i], part.X_WS.linear());
    ode::set_position(bodies_[i], part.X_WS.translation());
    part.carried_v = carried_velocity(part.X_WS.translation());
    ode::set_velocity(bodies_[i], part.carried_v, now_.omega);
  }
  place_carriage();
}

void GripperMechanism::observe(const PadForces& pads, bool touched) {
  now_.report.force_n = pads.closing_n;
  if (now_.idle) return;
  const bool still = std::abs(now_.motion[0].rate_m_s) < kStillRate &&
                     std::abs(now_.motion[1].rate_m_s) < kStillRate;
  const bool driven = settings_.drive == scene::GripperDrive::kServo ||
                      air_is_steady(settings_, closing(), now_.law.air);
  now_.still_steps = still && driven ? now_.still_steps + 1 : 0;
  if (now_.still_steps >= kStillSteps) now_.report.settled = true;
  watch_grip(pads, still);

  const bool at_stop = std::abs(now_.motion[0].travel_m - stop()) < kShortOfStop &&
                       std::abs(now_.motion[1].travel_m - stop()) < kShortOfStop;
  const bool rests = still && at_stop && !touched && now_.report.settled &&
                     now_.report.palm_deflection_m < kIdleDeflection;
  now_.free_steps = rests ? now_.free_steps + 1 : 0;
  if (now_.free_steps >= kIdleSteps) fall_idle(stop());
}

void GripperMechanism::watch_grip(const PadForces& pads, bool still) {
  const double bearing = kHoldShare * settings_.force_n;
  const bool pressing = pads.body[0] >= 0 && pads.body[0] == pads.body[1] &&
                        pads.closing_n[0] > bearing && pads.closing_n[1] > bearing;
  const bool stopped_short = now_.motion[0].travel_m < end_m_ - kShortOfStop ||
                             now_.motion[1].travel_m < end_m_ - kShortOfStop;
  now_.hold_steps = pressing && still && stopped_short ? now_.hold_steps + 1 : 0;
  now_.lost_steps = pressing ? 0 : now_.lost_steps + 1;
  if (now_.hold_steps >= kHoldSteps) {
    now_.report.holding = true;
    now_.report.held_body = pads.body[0];
  } else if (now_.lost_steps >= kLostSteps) {
    now_.report.holding = false;
    now_.report.held_body = -1;
  }
}

void GripperMechanism::fall_idle(double stop) {
  now_.idle = true;
  now_.report.travel_m = {stop, stop};
  now_.report.separation_m = settings_.gap_open_m - 2 * stop;
  now_.report.palm_deflection_m = 0;
  now_.motion = {FingerMotion{stop, 0}, FingerMotion{stop, 0}};
  auto& lever = now_.parts[3];
  lever.X_TS = now_.X_WT.inverse() * lever.X_WS;
  follow();
}

Eigen::Vector3d GripperMechanism::carried_velocity(const Eigen::Vector3d& p_W) const {
  return (now_.delta * p_W - p_W) / step_s_;
}

Eigen::Isometry3d GripperMechanism::X_WD(int finger) const {
  const auto& part = now_.parts[static_cast<std::size_t>(finger) + 1];
  const double side = finger == 0 ? 1 : -1;
  Eigen::Isometry3d X_SD = Eigen::Isometry3d::Identity();
  X_SD.linear().col(0) = Eigen::Vector3d(side, 0, 0);
  X_SD.linear().col(1) = Eigen::Vector3d(0, -side, 0);
  X_SD.linear().col(2) = Eigen::Vector3d(0, 0, -1);
  X_SD.translation() = Eigen::Vector3d(0, -side * 0.5 * part.size.y(), 0.5 * part.size.z());
  return part.X_WS * X_SD;
}

Eigen::Vector3d GripperMechanism::closing_W(int finger) const {
  const auto& part = now_.parts[static_cast<std::size_t>(finger) + 1];
  return (finger == 0 ? -1.0 : 1.0) * part.X_WS.linear().col(1);
}

int GripperMechanism::rows() const {
  return 6 + 12 + (settings_.law == scene::GripperLaw::kLinkage ? 7 : 0);
}

}  // namespace aprsim::physics
