#include "world/physics/gripper/grasp_monitor.hpp"

#include <cmath>

namespace aprsim::physics {
namespace {

constexpr double kStillRate = 2e-3;  // [m/s] below which a finger counts as stopped
constexpr int kStillSteps = 20;      // for as long
constexpr int kHoldSteps = 5;
constexpr int kLostSteps = 3;
constexpr double kHoldShare = 0.05;    // of the piston force that both pads must bear
constexpr double kShortOfStop = 2e-5;  // [m]
constexpr int kIdleSteps = 50;
constexpr double kIdleDeflection = 2e-6;  // [m]

}  // namespace

void GraspMonitor::restart(GripperState& state) {
  still_steps_ = 0;
  state.settled = false;
}

bool GraspMonitor::observe(const Observation& now, GripperState& state) {
  const auto& motion = now.motion;
  const bool still =
      std::abs(motion[0].rate_m_s) < kStillRate && std::abs(motion[1].rate_m_s) < kStillRate;
  // A finger that waits for its air to build up is not settled.
  still_steps_ = still && now.at_full_force ? still_steps_ + 1 : 0;
  if (still_steps_ >= kStillSteps) state.settled = true;
  update_hold(now, still, state);

  // Idle: at its end stop, unloaded and untouched.
  const bool at_stop = std::abs(motion[0].travel_m - now.stop_travel_m) < kShortOfStop &&
                       std::abs(motion[1].travel_m - now.stop_travel_m) < kShortOfStop;
  const bool rests = still && at_stop && !now.touched && state.settled &&
                     state.palm_deflection_m < kIdleDeflection;
  idle_steps_ = rests ? idle_steps_ + 1 : 0;
  return idle_steps_ >= kIdleSteps;
}

/// Holding: both pads press on the same body or on bodies that press each other, at rest and short
/// of the closed stop. Lost: they do not press.
void GraspMonitor::update_hold(const Observation& now, bool still, GripperState& state) {
  const PadForces& pads = now.pads;
  const double least = kHoldShare * now.force_n;
  const bool pressing = pads.joined && pads.closing_n[0] > least && pads.closing_n[1] > least;
  const bool short_of_stop = now.motion[0].travel_m < now.closed_travel_m - kShortOfStop ||
                             now.motion[1].travel_m < now.closed_travel_m - kShortOfStop;
  hold_steps_ = pressing && still && short_of_stop ? hold_steps_ + 1 : 0;
  lost_steps_ = pressing ? 0 : lost_steps_ + 1;
  if (hold_steps_ >= kHoldSteps) {
    state.holding = true;
    state.held_body = pads.hardest();
  } else if (lost_steps_ >= kLostSteps) {
    state.holding = false;
    state.held_body = -1;
  }
}

}  // namespace aprsim::physics
