#include "world/api/signals/bound_signal.hpp"

#include <algorithm>
#include <chrono>
#include <string_view>

namespace aprsim::api {
namespace {

std::string joined(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
  return out.empty() ? "(there is none)" : out;
}

tl::unexpected<Error> unknown(const std::string& expected) {
  return fail(ErrorCode::kNotFound, "signal", expected);
}

/// The word before the first dot.
std::string_view head_of(std::string_view name) { return name.substr(0, name.find('.')); }

/// The words of a signal behind its source, as in "broken" of "photo_eye.entry.broken".
std::string_view tail_of(std::string_view name) { return name.substr(name.rfind('.') + 1); }

/// Names of the signals of one kind of source, by the first word.
std::vector<std::string> signals_of(std::string_view head) {
  std::vector<std::string> names;
  for (const SignalInfo& info : signal_table()) {
    if (head_of(info.name) == head) names.emplace_back(info.name);
  }
  return names;
}

BoundSignal bound(const SignalInfo& info) {
  BoundSignal signal;
  signal.info = &info;
  signal.writable = info.use != SignalUse::kRead;
  signal.unit = info.unit;
  if (info.flag) {
    signal.min = 0;
    signal.max = 1;
  }
  return signal;
}

Result<BoundSignal> bind_plain(const std::string& name, const SignalSources& sources) {
  const std::string_view head = head_of(name);
  if (head == "belt" && !sources.belt_max_m_s)
    return unknown("no signal of the belt: the cell has none");
  if (head == "light_curtain" && !sources.light_curtain) {
    return unknown("no signal of a light curtain: the cell has none");
  }
  const auto found = std::ranges::find(signal_table(), name, &SignalInfo::name);
  if (found == signal_table().end()) return unknown("one of " + joined(signals_of(head)));
  BoundSignal signal = bound(*found);
  if (found->signal == CellSignal::kBeltSpeedSetting) {
    signal.min = 0;
    signal.max = *sources.belt_max_m_s;
  } else if (found->signal == CellSignal::kBeltSpeed) {
    signal.min = -*sources.belt_max_m_s;
    signal.max = *sources.belt_max_m_s;
  } else if (found->signal == CellSignal::kDriveFault) {
    signal.min = 0;
    signal.max = 3;
  }
  return signal;
}

/// A signal of a photo-eye or robot: HEAD.NAME.TAIL, where the name may have dots.
Result<BoundSignal> bind_named(const std::string& name, const std::vector<std::string>& known) {
  const std::string_view head = head_of(name), tail = tail_of(name);
  const std::string expected =
      "one of " + joined(signals_of(head)) + ", NAME one of " + joined(known);
  if (name.size() < head.size() + tail.size() + 3) return unknown(expected);
  const std::string of = name.substr(head.size() + 1, name.size() - head.size() - tail.size() - 2);
  const auto source = std::ranges::find(known, of);
  const std::string pattern = std::string(head) + ".NAME." + std::string(tail);
  const auto info = std::ranges::find(signal_table(), pattern, &SignalInfo::name);
  if (source == known.end() || info == signal_table().end()) return unknown(expected);
  BoundSignal signal = bound(*info);
  signal.index = static_cast<std::size_t>(source - known.begin());
  return signal;
}

/// DEVICE.SIGNAL, where the device's name may have dots.
Result<BoundSignal> bind_device(const std::string& name, const SignalSources& sources) {
  std::vector<std::string> known;
  for (const DeviceDescription& device : sources.devices) known.push_back(device.name);
  const std::size_t dot = name.rfind('.');
  const auto device =
      std::ranges::find(sources.devices, name.substr(0, dot), &DeviceDescription::name);
  if (dot == std::string::npos || device == sources.devices.end()) {
    return unknown("a signal of cell, belt, photo_eye, light_curtain, robot or a device: " +
                   joined(known));
  }
  BoundSignal signal = bound(signal_info(CellSignal::kDevice));
  signal.device = device->name;
  signal.signal = name.substr(dot + 1);
  signal.index = static_cast<std::size_t>(device - sources.devices.begin());
  signal.writable = !sources.devices_are_made;
  if (!sources.devices_are_made) return signal;
  const auto found = std::ranges::find(device->signals, signal.signal);
  if (found == device->signals.end()) {
    return unknown("a signal of device " + device->name + ": " + joined(device->signals));
  }
  signal.number = static_cast<std::size_t>(found - device->signals.begin());
  const auto input = std::ranges::find(device->inputs, signal.signal, &InputDescription::signal);
  if (input == device->inputs.end()) return signal;
  signal.writable = true;
  signal.unit = input->unit;
  signal.min = input->min;
  signal.max = input->max;
  return signal;
}

double belt_value(CellSignal signal, const ConveyorSnapshot& belt) {
  switch (signal) {
    case CellSignal::kBeltRun:
      return belt.run ? 1 : 0;
    case CellSignal::kBeltForward:
      return belt.forward ? 1 : 0;
    case CellSignal::kBeltSpeedSetting:
      return belt.speed_setting_m_s;
    case CellSignal::kBeltSpeed:
      return belt.speed_m_s;
    case CellSignal::kBeltTravel:
      return belt.travel_m;
    case CellSignal::kBeltLoad:
      return belt.load_kg;
    case CellSignal::kBeltCurrent:
      return belt.motor_current_a;
    case CellSignal::kEmergencyStop:
      return belt.emergency_stop ? 1 : 0;
    case CellSignal::kDriveFault:
      return static_cast<double>(belt.fault);
    default:
      return 0;
  }
}

double robot_value(CellSignal signal, const RobotSnapshot& robot) {
  switch (signal) {
    case CellSignal::kRobotHolding:
      return robot.gripper.holding ? 1 : 0;
    case CellSignal::kRobotSeparation:
      return robot.gripper.separation_m;
    case CellSignal::kRobotMoving:
      return robot.moving ? 1 : 0;
    default:
      return robot.protective_stop ? 1 : 0;
  }
}

}  // namespace

SignalSources signal_sources(const CellDescription& cell) {
  SignalSources sources;
  if (cell.has_conveyor) {
    sources.belt_max_m_s = cell.conveyor.max_speed_m_s;
    for (const auto& eye : cell.conveyor.photo_eyes) sources.photo_eyes.push_back(eye.name);
  }
  sources.light_curtain = cell.light_curtain.has_value();
  for (const auto& robot : cell.robots) sources.robots.push_back(robot.name);
  sources.devices = cell.devices;
  return sources;
}

bool is_device_signal(const std::string& name) { return signals_of(head_of(name)).empty(); }

Result<BoundSignal> bind_signal(const std::string& name, const SignalSources& sources) {
  const std::string_view head = head_of(name);
  if (head == "photo_eye") return bind_named(name, sources.photo_eyes);
  if (head == "robot") return bind_named(name, sources.robots);
  if (head == "cell" || head == "belt" || head == "light_curtain") {
    return bind_plain(name, sources);
  }
  return bind_device(name, sources);
}

double value_of(const BoundSignal& signal, const Snapshot& snapshot) {
  const CellSignal kind = signal.info->signal;
  switch (kind) {
    case CellSignal::kTime:
      return std::chrono::duration<double>(snapshot.time).count();
    case CellSignal::kCellFault:
      return snapshot.world_fault.empty() ? 0 : 1;
    case CellSignal::kEyeBroken:
    case CellSignal::kEyeCount: {
      if (signal.index >= snapshot.conveyor.photo_eyes.size()) return 0;
      const PhotoEyeSnapshot& eye = snapshot.conveyor.photo_eyes[signal.index];
      return kind == CellSignal::kEyeCount ? eye.count : eye.broken;
    }
    case CellSignal::kCurtainBroken:
      return snapshot.light_curtain.broken ? 1 : 0;
    case CellSignal::kRobotHolding:
    case CellSignal::kRobotSeparation:
    case CellSignal::kRobotMoving:
    case CellSignal::kRobotStopped:
      if (signal.index >= snapshot.robots.size()) return 0;
      return robot_value(kind, snapshot.robots[signal.index]);
    case CellSignal::kDevice: {
      if (signal.index >= snapshot.devices.size()) return 0;
      const std::vector<double>& values = snapshot.devices[signal.index].signals;
      return signal.number < values.size() ? values[signal.number] : 0;
    }
    default:
      return belt_value(kind, snapshot.conveyor);
  }
}

void set_signal(const BoundSignal& signal, double value, SignalCommands& commands) {
  const bool on = value != 0;
  switch (signal.info->signal) {
    case CellSignal::kBeltRun:
      commands.belt.run = on;
      return;
    case CellSignal::kBeltForward:
      commands.belt.forward = on;
      return;
    case CellSignal::kBeltSpeedSetting:
      commands.belt.speed_m_s = value;
      return;
    case CellSignal::kEmergencyStop:
      commands.belt.emergency_stop = on;
      return;
    case CellSignal::kFaultReset:
      commands.belt.fault_reset = on;
      return;
    default:
      commands.devices.settings.push_back({signal.device, signal.signal, value});
  }
}

}  // namespace aprsim::api
