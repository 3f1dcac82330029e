#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "modbus/register_map.hpp"
#include "modbus/request.hpp"

/// Conversion between the conveyor's physical values and its registers.
namespace aprsim::modbus {

/// The device's memory at one instant: one entry per address from kFirstAddress on.
struct RegisterImage {
  std::array<std::uint16_t, kAddressCount> holding{};
  std::array<std::uint16_t, kAddressCount> input{};
  std::array<std::uint8_t, kAddressCount> coils{};     ///< 0 or 1
  std::array<std::uint8_t, kAddressCount> discrete{};  ///< 0 or 1
};

/// The reason why the drive does not run, as in the fault register.
enum class FaultCode : std::uint16_t {
  kNone,
  kCellStopped,
  kEmergencyStop,
  kWatchdog,
  kLightCurtain
};

struct PhotoEyeReadings {
  bool broken = false;
  std::uint32_t count = 0;
};

struct LightCurtainReadings {
  std::uint16_t beams = 0;  ///< 0 = the cell has none
  double range_m = 0;
  bool broken = false;
  std::array<double, kCurtainBeams> distance_m{};  ///< the first ones
};

/// The conveyor at one instant, in SI units, and the light curtain that its PLC reads.
struct ConveyorReadings {
  bool present = false;  ///< false: no conveyor; only fault, time and light curtain are valid
  bool run = false;
  bool forward = true;
  double speed_setting_m_s = 0;  ///< commanded magnitude
  double speed_m_s = 0;          ///< actual, forward positive
  double travel_m = 0;           ///< since reset, forward positive
  double max_speed_m_s = 0;
  std::uint64_t time_ms = 0;  ///< simulated, since reset
  FaultCode fault = FaultCode::kNone;
  bool emergency_stop = false;  ///< the input is engaged
  double motor_current_a = 0;
  double load_kg = 0;
  std::array<PhotoEyeReadings, kPhotoEyes> photo_eyes;
  LightCurtainReadings light_curtain;
};

enum class DriveState : std::uint16_t { kAbsent, kStandstill, kRamping, kAtSpeed, kFault };

/// The drive inputs that a write sets; absent = not written.
struct ConveyorWrite {
  std::optional<bool> run;
  std::optional<bool> forward;
  std::optional<double> speed_m_s;
  std::optional<bool> emergency_stop;
  bool fault_reset = false;

  [[nodiscard]] bool empty() const {
    return !run && !forward && !speed_m_s && !emergency_stop && !fault_reset;
  }
};

/// Nearest count for a speed magnitude, limited to 0..32768.
[[nodiscard]] std::uint16_t speed_counts(double speed_m_s, const ConveyorScaling& scaling);
/// Nearest count for a signed speed, limited to a signed 16-bit register (two's complement).
[[nodiscard]] std::uint16_t signed_speed_counts(double speed_m_s, const ConveyorScaling& scaling);
/// Belt travel as a 32-bit encoder counts it (two's complement, wraps).
[[nodiscard]] std::uint32_t position_counts(double travel_m);
[[nodiscard]] DriveState drive_state(const ConveyorReadings& readings);

/// Writes the documented registers into the image; the others stay as they are.
void encode(const ConveyorReadings& readings, const ConveyorScaling& scaling, RegisterImage& image);

/// The drive inputs in the coils or words of a write request (not FC 22), which may include unused
/// memory. A value outside its register's range gives exception 3, and nothing of the request is
/// written.
[[nodiscard]] Checked<ConveyorWrite> decode_write(const Request& request,
                                                  const ConveyorScaling& scaling);

}  // namespace aprsim::modbus
