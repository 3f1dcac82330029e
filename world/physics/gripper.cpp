#include "world/physics/gripper.hpp"

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

void GripperMechanism::command(double setting) {
  const bool closing = setting <= 0.5;
  if (closing == closing_) return;
  closing_ = closing;
  mimic_ = {};
  still_steps_ = 0;
  state_.settled = false;
  wake();
}

void GripperMechanism::begin_step(const Eigen::Isometry3d& X_WF_next) {
  X_WT_next_ = X_WF_next * X_FT_;
  delta_ = X_WT_next_ * X_WT_.inverse();
  const Eigen::AngleAxisd turn(delta_.linear());
  const Eigen::Vector3d omega_before = omega_;
  omega_ = turn.angle() / step_s_ * turn.axis();
  if (idle_) return;
  for (std::size_t i = 0; i < body_count_; ++i) {
    auto& part = parts_[i];
    const Eigen::Vector3d v = ode::vector(dBodyGetLinearVel(bodies_[i]));
    const Eigen::Vector3d w = ode::vector(dBodyGetAngularVel(bodies_[i]));
    const Eigen::Vector3d u = carried_velocity(part.X_WS.translation());
    ode::set_velocity(bodies_[i], u + delta_.linear() * (v - part.carried_v),
                      omega_ + delta_.linear() * (w - omega_before));
    part.carried_v = u;
  }
  place_carriage();
  drive();
}

void GripperMechanism::drive() {
  for (std::size_t i = 0; i < 2; ++i) {
    motion_[i] = {dJointGetSliderPosition(sliders_[i].get()),
                  dJointGetSliderPositionRate(sliders_[i].get())};
  }
  drives_ = finger_drives(settings_, closing_, motion_, end_m_, step_s_, mimic_);
  for (std::size_t i = 0; i < 2; ++i) {
    dJointID slider = sliders_[i].get();
    dJointSetSliderParam(slider, dParamVel, drives_[i].speed_m_s);
    dJointSetSliderParam(slider, dParamFMax, drives_[i].piston_n);
    // ODE's motor pushes with all its force, unlimited in speed, in a step that begins at a stop:
    // right against the stop, wrong away from it. The stop that a finger leaves is taken away.
    const bool leaves_open = closing_ && motion_[i].travel_m < kStopZone;
    const bool leaves_closed = !closing_ && motion_[i].travel_m > end_m_ - kStopZone;
    dJointSetSliderParam(slider, dParamLoStop, leaves_open ? -dInfinity : 0);
    dJointSetSliderParam(slider, dParamHiStop, leaves_closed ? dInfinity : end_m_);
  }
}

void GripperMechanism::apply_forces() {
  for (std::size_t i = 0; i < 2; ++i) {
    if (drives_[i].extra_n != 0) dJointAddSliderForce(sliders_[i].get(), drives_[i].extra_n);
  }
}

void GripperMechanism::place_carriage() {
  const Eigen::Isometry3d X_WS = X_WT_ * parts_[0].X_TS;
  ode::set_rotation(carriage_.get(), X_WS.linear());
  ode::set_position(carriage_.get(), X_WS.translation());
  ode::set_velocity(carriage_.get(), carried_velocity(X_WS.translation()), omega_);
}

void GripperMechanism::end_step() {
  X_WT_ = X_WT_next_;
  if (idle_) {
    follow();
  } else {
    read_back();
  }
  state_.X_WT = Pose::from(parts_[0].X_WS * parts_[0].X_TS.inverse());
}

void GripperMechanism::read_back() {
  for (std::size_t i = 0; i < body_count_; ++i) {
    auto& part = parts_[i];
    part.X_WS.linear() = ode::matrix(dBodyGetRotation(bodies_[i]));
    part.X_WS.translation() = ode::vector(dBodyGetPosition(bodies_[i]));
    part.bounds = bounds_of_box(part.size, part.X_WS);
  }
  for (std::size_t i = 0; i < 2; ++i) {
    motion_[i] = {dJointGetSliderPosition(sliders_[i].get()),
                  dJointGetSliderPositionRate(sliders_[i].get())};
    state_.travel_m[i] = motion_[i].travel_m;
  }
  state_.separation_m = settings_.gap_open_m - state_.travel_m[0] - state_.travel_m[1];
  state_.palm_deflection_m =
      (parts_[0].X_WS.translation() - (X_WT_ * parts_[0].X_TS).translation()).norm();
}

Eigen::Isometry3d GripperMechanism::resting_X_TS(std::size_t part) const {
  Eigen::Isometry3d X_TS = parts_[part].X_TS;
  if (part == 1) X_TS.translation().y() -= state_.travel_m[0];
  if (part == 2) X_TS.translation().y() += state_.travel_m[1];
  return X_TS;
}

void GripperMechanism::follow() {
  for (std::size_t i = 0; i < 3; ++i) {
    parts_[i].X_WS = X_WT_ * resting_X_TS(i);
    parts_[i].bounds = bounds_of_box(parts_[i].size, parts_[i].X_WS);
  }
}

void GripperMechanism::wake() {
  free_steps_ = 0;
  if (!idle_) return;
  idle_ = false;
  for (std::size_t i = 0; i < body_count_; ++i) {
    auto& part = parts_[i];
    if (i == 3) part.X_WS = X_WT_ * part.X_TS;
    ode::set_rotation(bodies_[i], part.X_WS.linear());
    ode::set_position(bodies_[i], part.X_WS.translation());
    part.carried_v = carried_velocity(part.X_WS.translation());
    ode::set_velocity(bodies_[i], part.carried_v, omega_);
  }
  place_carriage();
}

void GripperMechanism::observe(const PadForces& pads, bool touched) {
  state_.force_n = pads.closing_n;
  if (idle_) return;
  const bool still =
      std::abs(motion_[0].rate_m_s) < kStillRate && std::abs(motion_[1].rate_m_s) < kStillRate;
  still_steps_ = still ? still_steps_ + 1 : 0;
  if (still_steps_ >= kStillSteps) state_.settled = true;

  const double bearing = kHoldShare * settings_.force_n;
  const bool pressing = pads.body[0] >= 0 && pads.body[0] == pads.body[1] &&
                        pads.closing_n[0] > bearing && pads.closing_n[1] > bearing;
  const bool stopped_short =
      motion_[0].travel_m < end_m_ - kShortOfStop || motion_[1].travel_m < end_m_ - kShortOfStop;
  hold_steps_ = pressing && still && stopped_short ? hold_steps_ + 1 : 0;
  lost_steps_ = pressing ? 0 : lost_steps_ + 1;
  if (hold_steps_ >= kHoldSteps) {
    state_.holding = true;
    state_.held_body = pads.body[0];
  } else if (lost_steps_ >= kLostSteps) {
    state_.holding = false;
    state_.held_body = -1;
  }

  const double stop = closing_ ? end_m_ : 0;
  const bool at_stop = std::abs(motion_[0].travel_m - stop) < kShortOfStop &&
                       std::abs(motion_[1].travel_m - stop) < kShortOfStop;
  const bool rests =
      still && at_stop && !touched && state_.settled && state_.palm_deflection_m < kIdleDeflection;
  free_steps_ = rests ? free_steps_ + 1 : 0;
  if (free_steps_ < kIdleSteps) return;
  idle_ = true;
  state_.travel_m = {stop, stop};
  state_.separation_m = settings_.gap_open_m - 2 * stop;
  state_.palm_deflection_m = 0;
  motion_ = {FingerMotion{stop, 0}, FingerMotion{stop, 0}};
  parts_[3].X_TS = X_WT_.inverse() * parts_[3].X_WS;
  follow();
}

Eigen::Vector3d GripperMechanism::carried_velocity(const Eigen::Vector3d& p_W) const {
  return (delta_ * p_W - p_W) / step_s_;
}

Eigen::Isometry3d GripperMechanism::X_WD(int finger) const {
  const auto& part = parts_[static_cast<std::size_t>(finger) + 1];
  const double side = finger == 0 ? 1 : -1;
  Eigen::Isometry3d X_SD = Eigen::Isometry3d::Identity();
  X_SD.linear().col(0) = Eigen::Vector3d(side, 0, 0);
  X_SD.linear().col(1) = Eigen::Vector3d(0, -side, 0);
  X_SD.linear().col(2) = Eigen::Vector3d(0, 0, -1);
  X_SD.translation() = Eigen::Vector3d(0, -side * 0.5 * part.size.y(), 0.5 * part.size.z());
  return part.X_WS * X_SD;
}

Eigen::Vector3d GripperMechanism::closing_W(int finger) const {
  const auto& part = parts_[static_cast<std::size_t>(finger) + 1];
  return (finger == 0 ? -1.0 : 1.0) * part.X_WS.linear().col(1);
}

int GripperMechanism::rows() const {
  return 6 + 12 + (settings_.law == scene::GripperLaw::kLinkage ? 7 : 0);
}

}  // namespace aprsim::physics
