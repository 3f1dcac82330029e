#include "world/api/signals/signal_table.hpp"

#include <array>
#include <cstddef>

namespace aprsim::api {
namespace {

constexpr auto kRead = SignalUse::kRead, kBoth = SignalUse::kReadWrite, kWrite = SignalUse::kWrite;

constexpr SignalInfo flag(CellSignal signal, std::string_view name, SignalUse use,
                          std::string_view meaning) {
  return {signal, name, "", use, true, false, meaning};
}

constexpr SignalInfo number(CellSignal signal, std::string_view name, std::string_view unit,
                            std::string_view meaning, bool wraps = false, SignalUse use = kRead) {
  return {signal, name, unit, use, false, wraps, meaning};
}

/// In the order of CellSignal.
constexpr std::array kTable{
    number(CellSignal::kTime, "cell.time_s", "s", "simulated time since the last reset", true),
    flag(CellSignal::kCellFault, "cell.fault", kRead, "the simulation has stopped on a fault"),
    flag(CellSignal::kBeltRun, "belt.run", kBoth, "1 starts the belt, 0 stops it"),
    flag(CellSignal::kBeltForward, "belt.forward", kBoth, "direction of travel"),
    number(CellSignal::kBeltSpeedSetting, "belt.speed_setting_m_s", "m/s",
           "commanded speed, a magnitude up to the belt's limit", false, kBoth),
    number(CellSignal::kBeltSpeed, "belt.speed_m_s", "m/s", "actual speed, forward positive"),
    number(CellSignal::kBeltTravel, "belt.travel_m", "m",
           "travel since the last reset, forward positive", true),
    number(CellSignal::kBeltLoad, "belt.load_kg", "kg", "mass of the bodies on the belt"),
    number(CellSignal::kBeltCurrent, "belt.current_a", "A", "magnitude of the motor's current"),
    flag(CellSignal::kEmergencyStop, "belt.emergency_stop", kBoth,
         "1 engages the emergency stop and holds a fault, 0 releases it"),
    number(CellSignal::kDriveFault, "belt.fault", "",
           "held fault of the drive: 0 none, 1 emergency stop, 2 watchdog, 3 light curtain"),
    flag(CellSignal::kFaultReset, "belt.fault_reset", kWrite,
         "1 clears a held fault unless its cause persists; reads 0"),
    flag(CellSignal::kEyeBroken, "photo_eye.NAME.broken", kRead, "something is in the beam"),
    number(CellSignal::kEyeCount, "photo_eye.NAME.count", "",
           "interruptions of the beam since the last reset", true),
    flag(CellSignal::kCurtainBroken, "light_curtain.broken", kRead, "something is in a beam"),
    flag(CellSignal::kRobotHolding, "robot.NAME.holding", kRead, "the gripper holds a body"),
    number(CellSignal::kRobotSeparation, "robot.NAME.separation_m", "m",
           "distance of the fingers, pad to pad"),
    flag(CellSignal::kRobotMoving, "robot.NAME.moving", kRead, "the arm is in motion"),
    flag(CellSignal::kRobotStopped, "robot.NAME.stopped", kRead,
         "a protective stop holds the robot"),
    number(CellSignal::kDevice, "DEVICE.SIGNAL", "",
           "signal of a device of an extension; its inputs can be written"),
};

std::string_view text_of(SignalUse use) {
  switch (use) {
    case SignalUse::kRead:
      return "read";
    case SignalUse::kReadWrite:
      return "read, write";
    case SignalUse::kWrite:
      return "write";
  }
  return {};
}

}  // namespace

std::span<const SignalInfo> signal_table() { return kTable; }

const SignalInfo& signal_info(CellSignal signal) {
  return kTable[static_cast<std::size_t>(signal)];
}

const SignalInfo* find_signal_info(std::string_view name) {
  const std::string_view head = name.substr(0, name.find('.'));
  const std::string_view tail = name.substr(name.rfind('.') + 1);
  bool is_known = false;
  for (const SignalInfo& info : kTable) {
    if (info.name == name) return &info;
    if (!info.name.starts_with(head) || info.name[head.size()] != '.') continue;
    is_known = true;
    const bool named = info.name.substr(head.size()).starts_with(".NAME.");
    if (named && info.name.ends_with(tail) && info.name.size() == head.size() + 6 + tail.size() &&
        name.size() > head.size() + tail.size() + 2) {
      return &info;
    }
  }
  return is_known ? nullptr : &signal_info(CellSignal::kDevice);
}

std::string signal_table_text() {
  std::string text = "| signal | unit | access | meaning |\n|---|---|---|---|\n";
  for (const SignalInfo& info : kTable) {
    const std::string_view unit = info.flag ? "0 or 1" : info.unit;
    text += "| `" + std::string(info.name) + "` | " + std::string(unit) + " | " +
            std::string(text_of(info.use)) + " | " + std::string(info.meaning) + " |\n";
  }
  return text;
}

}  // namespace aprsim::api
