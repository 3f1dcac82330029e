#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

/// The signals of a cell that a scene can bind registers to: one table, from which documents,
/// checks and readings come.
namespace aprsim::api {

enum class CellSignal : std::uint8_t {
  kTime,
  kCellFault,
  kBeltRun,
  kBeltForward,
  kBeltSpeedSetting,
  kBeltSpeed,
  kBeltTravel,
  kBeltLoad,
  kBeltCurrent,
  kEmergencyStop,
  kDriveFault,
  kFaultReset,
  kEyeBroken,
  kEyeCount,
  kCurtainBroken,
  kRobotHolding,
  kRobotSeparation,
  kRobotMoving,
  kRobotStopped,
  kDevice,
};

/// How clients use a signal.
enum class SignalUse : std::uint8_t { kRead, kReadWrite, kWrite };

struct SignalInfo {
  CellSignal signal;
  std::string_view name;  ///< capitals stand for a name of the scene, as in photo_eye.NAME.count
  std::string_view unit;  ///< empty = a plain number
  SignalUse use = SignalUse::kRead;
  bool flag = false;   ///< 0 or 1
  bool wraps = false;  ///< in an integer register, as counters do; the others saturate
  std::string_view meaning;
};

[[nodiscard]] std::span<const SignalInfo> signal_table();

/// The row of a signal.
[[nodiscard]] const SignalInfo& signal_info(CellSignal signal);

/// The row of a signal by its name in a scene, as "photo_eye.entry.count"; a name with an unknown
/// first word is that of a device's signal. Null = no signal of the cell has such a name.
[[nodiscard]] const SignalInfo* find_signal_info(std::string_view name);

/// The table as Markdown, for documents.
[[nodiscard]] std::string signal_table_text();

}  // namespace aprsim::api
