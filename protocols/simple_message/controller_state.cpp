#include "protocols/simple_message/controller_state.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "protocols/ports/wire_faults.hpp"

namespace aprsim::simple_message {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
/// Pulses of the SIA20D's axes S L E U R B T [1/rad].
constexpr std::array<double, 7> kPulsesPerRad{1024 / kDegree,  1024 / kDegree,    1024 / kDegree,
                                              1024 / kDegree,  1149.15 / kDegree, 1149.15 / kDegree,
                                              580.27 / kDegree};

// The second joint's share of the Fanuc's third.
constexpr std::size_t kShoulder = 1, kElbow = 2;

/// Numbers of alarms as the makers' lists have them; which one a stop of the cell means is assumed.
struct AlarmCodes {
  std::int32_t emergency_stop, collision, drive, motion;
};
constexpr AlarmCodes kFanucCodes{
    11001,  // SRVO-001, the panel's emergency stop
    11050,  // SRVO-050, collision detected
    11023,  // SRVO-023, excessive error of a servo at rest
    15017,  // MOTN-017, limit error
};
constexpr AlarmCodes kMotomanCodes{
    0,     // an emergency stop is no alarm
    4315,  // collision detected
    4328,  // servo tracking error
    4414,  // excessive segment
};

bool drive_fails(const api::Snapshot& snapshot, int robot) {
  using faults::Kind;
  return protocols::injected(snapshot, Kind::kDriveFault, robot) ||
         protocols::injected(snapshot, Kind::kRobotBreakdown, robot);
}

bool emergency(const api::Snapshot& snapshot, int robot) {
  using faults::Kind;
  return protocols::injected(snapshot, Kind::kRobotEmergencyStop, robot) ||
         protocols::injected(snapshot, Kind::kCellEmergencyStop);
}

}  // namespace

Joints to_wire(ControllerKind kind, std::span<const double> joints) {
  Joints wire{};
  for (std::size_t i = 0; i < joints.size() && i < wire.size(); ++i) {
    const bool couples = kind == ControllerKind::kFanucKarel && i == kElbow;
    wire[i] = static_cast<float>(couples ? joints[kElbow] - joints[kShoulder] : joints[i]);
  }
  return wire;
}

Joints measured_to_wire(ControllerKind kind, std::span<const double> joints) {
  if (kind != ControllerKind::kMotomanFs100) return to_wire(kind, joints);
  return to_wire(kind, on_whole_pulses(JointVector(joints.begin(), joints.end())));
}

JointVector from_wire(ControllerKind kind, const Joints& wire, std::size_t count) {
  JointVector joints(wire.begin(),
                     wire.begin() + static_cast<std::ptrdiff_t>(std::min(count, wire.size())));
  if (kind == ControllerKind::kFanucKarel && joints.size() > kElbow) {
    joints[kElbow] += joints[kShoulder];
  }
  return joints;
}

ControllerState state_of(const api::Snapshot& snapshot, int robot, ControllerKind kind,
                         api::Ticket stream) {
  const auto index = static_cast<std::size_t>(robot);
  const api::RobotSnapshot& now = snapshot.robots.at(index);
  const std::size_t count = snapshot.cell->robots.at(index).joints.size();
  ControllerState state;
  JointVector speeds;
  for (std::size_t i = 0; i < count; ++i) {
    state.measured_rad.push_back(now.joints[i].position_rad);
    state.reference_rad.push_back(now.motion.reference_rad[i]);
    speeds.push_back(now.joints[i].velocity_rad_s);
  }
  state.position = measured_to_wire(kind, state.measured_rad);
  state.velocity = to_wire(kind, speeds);
  const bool failing = drive_fails(snapshot, robot);
  // A broken curtain that has stopped the robot is the controller's external emergency stop.
  state.e_stopped = emergency(snapshot, robot) || (now.light_curtain_broken && now.protective_stop);
  state.in_error = failing || now.protective_stop || !now.motion.alarm.empty();
  state.drives_on = now.drives_on && !state.e_stopped;
  state.has_stream = stream != 0 && now.motion.stream == stream;
  state.others_command = now.motion.source == api::MotionSource::kCommands ||
                         (now.motion.source == api::MotionSource::kStream && !state.has_stream);
  state.moving = now.moving || now.motion.phase == api::StreamPhase::kMoving ||
                 now.motion.phase == api::StreamPhase::kStopping;
  const AlarmCodes& codes = kind == ControllerKind::kFanucKarel ? kFanucCodes : kMotomanCodes;
  state.error_code = state.e_stopped       ? codes.emergency_stop
                     : failing             ? codes.drive
                     : now.protective_stop ? codes.collision
                     : state.in_error      ? codes.motion
                                           : 0;
  return state;
}

std::vector<std::int64_t> pulses_of(std::span<const double> joints_rad) {
  std::vector<std::int64_t> pulses;
  for (std::size_t i = 0; i < joints_rad.size() && i < kPulsesPerRad.size(); ++i) {
    pulses.push_back(static_cast<std::int64_t>(joints_rad[i] * kPulsesPerRad[i]));
  }
  return pulses;
}

JointVector on_whole_pulses(JointVector joints_rad) {
  const std::vector<std::int64_t> pulses = pulses_of(joints_rad);
  for (std::size_t i = 0; i < pulses.size(); ++i) {
    joints_rad[i] = static_cast<double>(pulses[i]) / kPulsesPerRad[i];
  }
  return joints_rad;
}

bool within_pulses(std::span<const double> a_rad, std::span<const double> b_rad,
                   std::int64_t limit) {
  for (std::size_t i = 0; i < std::min(a_rad.size(), kPulsesPerRad.size()); ++i) {
    // Wild numbers have no pulses.
    if (!(std::abs(a_rad[i]) < 1e6)) return false;
  }
  const auto a = pulses_of(a_rad), b = pulses_of(b_rad);
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) {
    if (std::abs(a[i] - b[i]) > limit) return false;
  }
  return true;
}

}  // namespace aprsim::simple_message
