#include "protocols/simple_message/gripper_valves.hpp"

namespace aprsim::simple_message {
namespace {

constexpr double kHalfOpen = 0.5;

bool moves(bool open, bool close, bool air) { return air && open != close; }

}  // namespace

void GripperValves::follow(const api::Snapshot& snapshot) {
  if (snapshot.applied < pending_) return;
  const bool is_open = link_.robot(snapshot).gripper.setting > kHalfOpen;
  const bool acts = moves(valves_.open, valves_.close, valves_.air);
  if (begun_ && (!acts || valves_.open == is_open)) return;
  begun_ = true;
  valves_.open = is_open;
  valves_.close = !is_open;
}

/// The cell moves a gripper only of a robot that has been initialized since its start; valves need
/// no such thing. A robot with an error stays as it is.
void GripperValves::make_ready() {
  const api::SnapshotPtr now = link_.latest();
  const api::RobotSnapshot& robot = link_.robot(*now);
  const bool in_error = robot.protective_stop || !robot.motion.alarm.empty();
  if (robot.initialized || in_error || robot.motion.source != api::MotionSource::kNone) return;
  static_cast<void>(link_.submit(api::InitRobot{}));
}

Result<void> GripperValves::apply(const Valves& valves) {
  const bool acts = moves(valves.open, valves.close, valves.air);
  const bool acted = moves(valves_.open, valves_.close, valves_.air);
  if (acts && !(acted && valves_.open == valves.open)) {
    make_ready();
    const auto ticket = link_.submit(api::SetGripper{valves.open ? 1.0 : 0.0});
    if (!ticket) return tl::unexpected(ticket.error());
    pending_ = *ticket;
  }
  valves_ = valves;
  return {};
}

Result<void> GripperValves::set(Output output, bool on) {
  follow(*link_.latest());
  Valves valves = valves_;
  (output == Output::kOpen    ? valves.open
   : output == Output::kClose ? valves.close
                              : valves.air) = on;
  return apply(valves);
}

bool GripperValves::get(Output output) {
  follow(*link_.latest());
  return output == Output::kOpen    ? valves_.open
         : output == Output::kClose ? valves_.close
                                    : valves_.air;
}

Result<void> GripperValves::actuate(bool open) {
  follow(*link_.latest());
  return apply({.open = open, .close = !open, .air = true});
}

bool GripperValves::is_open() {
  follow(*link_.latest());
  return valves_.open;
}

}  // namespace aprsim::simple_message
