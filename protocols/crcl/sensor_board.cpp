#include "protocols/crcl/sensor_board.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "crcl/text.hpp"
#include "protocols/crcl/parameter_limits.hpp"
#include "protocols/crcl/significant_digits.hpp"
#include "world/api/snapshot/signal_value.hpp"

namespace aprsim::crcl_server {
namespace {

using api::SignalKind;

constexpr std::size_t kMaxEnabled = 32;
constexpr std::string_view kCurtain = "light_curtain";
constexpr std::string_view kJointTorque = "joint_torque_";

// Names under which controllers of the lab know their force sensors. ATI's gives forces along the
// tool, so that pressing down lowers Fz; the others give them in the robot's frame.
constexpr std::array<std::string_view, 3> kInRobotFrame{"force_torque", "MotoFit",
                                                        "ForceTorqueSim"};
constexpr std::string_view kRemote = "RemoteCrclSensor";
constexpr std::array<std::string_view, 2> kInToolFrame{"force_torque_tool", "ATINetFT"};

bool is_among(std::string_view id, const auto& names) {
  return std::find(names.begin(), names.end(), id) != names.end();
}

crcl::Vector forces(SignalKind kind, Quantity quantity, const api::RobotSnapshot& robot,
                    const crcl::Units& units) {
  const auto axis = [&](int i) {
    return in_unit(api::value_of({kind, i}, robot), quantity, units);
  };
  return {axis(0), axis(1), axis(2)};
}

}  // namespace

double in_unit(double si, Quantity quantity, const crcl::Units& units) {
  switch (quantity) {
    case Quantity::kLength:
      return reported(si, units.length);
    case Quantity::kForce:
      return reported(si, units.force);
    case Quantity::kTorque:
      return reported(si, units.torque);
    case Quantity::kNone:
      break;
  }
  return si;
}

double in_si(double value, Quantity quantity, const crcl::Units& units) {
  switch (quantity) {
    case Quantity::kLength:
      return crcl::to_si(value, units.length);
    case Quantity::kForce:
      return crcl::to_si(value, units.force);
    case Quantity::kTorque:
      return crcl::to_si(value, units.torque);
    case Quantity::kNone:
      break;
  }
  return value;
}

Result<SensorBoard::Sensor> SensorBoard::sensor(const std::string& id) const {
  if (is_among(id, kInRobotFrame) || id.starts_with(kRemote)) {
    return Sensor{Kind::kForceTorqueR, {}};
  }
  if (is_among(id, kInToolFrame)) return Sensor{Kind::kForceTorqueT, {}};
  if (id == "part_present") return Sensor{Kind::kOnOff, {{SignalKind::kPartPresent, 0}, {}}};
  if (id == kCurtain && beams_ > 0) {
    return Sensor{Kind::kOnOff, {{SignalKind::kLightCurtain, 0}, {}}};
  }
  if (id == "separation") {
    return Sensor{Kind::kScalar, {{SignalKind::kSeparation, 0}, Quantity::kLength}};
  }
  if (id.starts_with(kJointTorque)) {
    const auto joint = crcl::parse_int(std::string_view(id).substr(kJointTorque.size()));
    if (joint && *joint >= 1 && *joint <= joints_.count() && joints_.arm_joint(*joint) >= 0) {
      return Sensor{
          Kind::kScalar,
          {{SignalKind::kJointTorque, joints_.arm_joint(*joint), joints_.sign(*joint) < 0},
           Quantity::kTorque}};
    }
  }
  return fail(ErrorCode::kNotFound, "SensorID",
              fmt::format("Unknown sensor {}; this robot has force_torque (also MotoFit, "
                          "RemoteCrclSensor), force_torque_tool (also ATINetFT), part_present, "
                          "separation{} and joint_torque_1 to joint_torque_{}",
                          crcl::shorten(id), beams_ > 0 ? ", light_curtain" : "", joints_.count()));
}

Result<void> SensorBoard::enable(const crcl::EnableSensor& command) {
  const Result<Sensor> found = sensor(command.sensor_id);
  if (!found) return tl::unexpected(found.error());
  if (auto ok = check_size("SensorID", command.sensor_id, command.options); !ok) return ok;
  const auto known = std::find_if(enabled_.begin(), enabled_.end(), [&](const Enabled& entry) {
    return entry.as.sensor_id == command.sensor_id;
  });
  if (known != enabled_.end()) {
    known->as.options = command.options;
    return {};
  }
  if (enabled_.size() >= kMaxEnabled) {
    return fail(ErrorCode::kFailedPrecondition, "SensorID",
                fmt::format("{} sensors are enabled already; disable one first", kMaxEnabled));
  }
  enabled_.push_back({command, *found});
  return {};
}

Result<void> SensorBoard::disable(const crcl::DisableSensor& command) {
  const Result<Sensor> found = sensor(command.sensor_id);
  if (!found) return tl::unexpected(found.error());
  std::erase_if(enabled_,
                [&](const Enabled& entry) { return entry.as.sensor_id == command.sensor_id; });
  return {};
}

Result<SensorSignal> SensorBoard::find(const std::string& sensor_id,
                                       const std::optional<std::string>& sub_field) const {
  const Result<Sensor> found = sensor(sensor_id);
  if (!found) return tl::unexpected(found.error());
  if (found->kind == Kind::kOnOff || found->kind == Kind::kScalar) return found->signal;
  constexpr std::array<std::string_view, 6> kFields{"Fx", "Fy", "Fz", "Tx", "Ty", "Tz"};
  const auto field = std::find(kFields.begin(), kFields.end(), sub_field.value_or(""));
  if (field == kFields.end()) {
    return fail(ErrorCode::kInvalidArgument, "SubField",
                fmt::format("SubField {} of sensor {}: must be Fx, Fy, Fz, Tx, Ty or Tz",
                            crcl::shorten(sub_field.value_or("missing")), sensor_id));
  }
  const auto index = static_cast<int>(field - kFields.begin());
  const bool in_tool = found->kind == Kind::kForceTorqueT;
  if (index < 3) {
    return SensorSignal{{in_tool ? SignalKind::kForceT : SignalKind::kForceR, index},
                        Quantity::kForce};
  }
  return SensorSignal{{in_tool ? SignalKind::kTorqueT : SignalKind::kTorqueR, index - 3},
                      Quantity::kTorque};
}

void SensorBoard::add_beams(crcl::SensorStatuses& out, const crcl::SensorReading& curtain,
                            const api::LightCurtainSnapshot& seen, const crcl::Units& units) const {
  for (int beam = 0; beam < beams_; ++beam) {
    crcl::SensorReading reading = curtain;
    reading.sensor_id = fmt::format("{}_{}", kCurtain, beam + 1);
    const double distance_m = seen.distance_m[static_cast<std::size_t>(beam)];
    out.scalar.push_back({std::move(reading), in_unit(distance_m, Quantity::kLength, units)});
  }
}

crcl::SensorStatuses SensorBoard::statuses(const api::Snapshot& snapshot, std::size_t index,
                                           std::int32_t read_count, std::int64_t time_ms,
                                           const crcl::Units& units) const {
  const api::RobotSnapshot& robot = snapshot.robots[index];
  crcl::SensorStatuses out;
  for (const Enabled& entry : enabled_) {
    const crcl::SensorReading reading{entry.as.sensor_id, read_count, time_ms, entry.as.options};
    const SensorSignal& signal = entry.sensor.signal;
    const double value = in_unit(api::value_of(signal.signal, robot), signal.quantity, units);
    switch (entry.sensor.kind) {
      case Kind::kForceTorqueR:
        out.force_torque.push_back({reading,
                                    forces(SignalKind::kForceR, Quantity::kForce, robot, units),
                                    forces(SignalKind::kTorqueR, Quantity::kTorque, robot, units)});
        break;
      case Kind::kForceTorqueT:
        out.force_torque.push_back({reading,
                                    forces(SignalKind::kForceT, Quantity::kForce, robot, units),
                                    forces(SignalKind::kTorqueT, Quantity::kTorque, robot, units)});
        break;
      case Kind::kOnOff:
        out.on_off.push_back({reading, value != 0});
        if (reading.sensor_id == kCurtain) {
          add_beams(out, reading, snapshot.light_curtain, units);
        }
        break;
      case Kind::kScalar:
        out.scalar.push_back({reading, value});
        break;
    }
  }
  return out;
}

}  // namespace aprsim::crcl_server
