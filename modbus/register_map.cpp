#include "modbus/register_map.hpp"

#include <array>
#include <cmath>

namespace aprsim::modbus {
namespace {

constexpr std::int64_t kInt16Min = -32768, kInt16Max = 32767, kUint16Max = 65535;
constexpr std::int64_t kInt32Min = -2147483648LL, kInt32Max = 2147483647, kUint32Max = 4294967295LL;

constexpr RegisterInfo coil(std::uint16_t address, std::string_view name,
                            std::string_view meaning) {
  return {Area::kCoil, address, Access::kReadWrite, Encoding::kBit, name, "", Scaling::kNone, 0,
          1,           meaning};
}

constexpr RegisterInfo input(std::uint16_t address, std::string_view name,
                             std::string_view meaning) {
  return {Area::kDiscreteInput,
          address,
          Access::kRead,
          Encoding::kBit,
          name,
          "",
          Scaling::kNone,
          0,
          1,
          meaning};
}

constexpr RegisterInfo item_count(std::uint16_t eye, std::string_view name,
                                  std::string_view meaning) {
  return {Area::kInputRegister,
          static_cast<std::uint16_t>(kItemCountRegister + eye),
          Access::kRead,
          Encoding::kUint16,
          name,
          "",
          Scaling::kNone,
          0,
          kUint16Max,
          meaning};
}

constexpr std::array kMap{
    RegisterInfo{Area::kHoldingRegister, kRunRegister, Access::kReadWrite, Encoding::kUint16, "run",
                 "", Scaling::kNone, 0, 1,
                 "1 = go, 0 = stop; the speed setting stays; 1 is ignored while a fault is held"},
    RegisterInfo{Area::kHoldingRegister, kDirectionRegister, Access::kReadWrite, Encoding::kUint16,
                 "direction", "", Scaling::kNone, 0, 1,
                 "sense of travel; which value is forward is set per installation"},
    RegisterInfo{Area::kHoldingRegister, kSpeedRegister, Access::kReadWrite, Encoding::kUint16,
                 "speed", "m/s", Scaling::kSpeed, 0, kSpeedFullScaleCounts,
                 "magnitude, unsigned; the belt follows it up to max_speed"},

    RegisterInfo{Area::kInputRegister, kActualSpeedRegister, Access::kRead, Encoding::kInt16,
                 "actual_speed", "m/s", Scaling::kSpeed, kInt16Min, kInt16Max,
                 "measured belt speed, forward positive; saturates"},
    RegisterInfo{
        Area::kInputRegister, kTargetSpeedRegister, Access::kRead, Encoding::kInt16, "target_speed",
        "m/s", Scaling::kSpeed, kInt16Min, kInt16Max,
        "speed that the drive approaches, after run, direction and limit; forward positive"},
    RegisterInfo{Area::kInputRegister, kDriveStateRegister, Access::kRead, Encoding::kUint16,
                 "drive_state", "", Scaling::kNone, 0, 4,
                 "0 absent, 1 standstill, 2 ramping, 3 at speed, 4 stopping or stopped by a fault"},
    RegisterInfo{Area::kInputRegister, kFaultCodeRegister, Access::kRead, Encoding::kUint16,
                 "fault_code", "", Scaling::kNone, 0, 4,
                 "0 none, 1 the cell has stopped on a fault, 2 emergency stop, 3 watchdog, 4 light "
                 "curtain"},
    RegisterInfo{Area::kInputRegister, kPositionRegister, Access::kRead, Encoding::kInt32,
                 "position", "m", Scaling::kPosition, kInt32Min, kInt32Max,
                 "belt travel since reset as an encoder counts it, forward positive; wraps"},
    RegisterInfo{Area::kInputRegister, kTimeStampRegister, Access::kRead, Encoding::kUint32,
                 "time_stamp", "s", Scaling::kMilliseconds, 0, kUint32Max,
                 "simulated time of this reply's values since reset; wraps"},
    RegisterInfo{Area::kInputRegister, kMaxSpeedRegister, Access::kRead, Encoding::kUint16,
                 "max_speed", "m/s", Scaling::kSpeed, 0, kUint16Max,
                 "the belt's own limit; saturates"},
    RegisterInfo{Area::kInputRegister, kMotorCurrentRegister, Access::kRead, Encoding::kUint16,
                 "current", "A", Scaling::kMilliamperes, 0, kUint16Max,
                 "magnitude of the motor's current, from a model of friction and acceleration"},
    RegisterInfo{Area::kInputRegister, kLoadRegister, Access::kRead, Encoding::kUint16, "load",
                 "kg", Scaling::kDecagrams, 0, kUint16Max, "mass on the belt"},
    item_count(0, "item_count_1", "number of times photo-eye 1 was interrupted since reset; wraps"),
    item_count(1, "item_count_2", "the same for photo-eye 2"),
    item_count(2, "item_count_3", "the same for photo-eye 3"),
    item_count(3, "item_count_4", "the same for photo-eye 4"),
    RegisterInfo{Area::kInputRegister, kCurtainBeamsRegister, Access::kRead, Encoding::kUint16,
                 "beams", "", Scaling::kNone, 0, kCurtainBeams,
                 "beams of the light curtain; 0 = the cell has none"},
    RegisterInfo{Area::kInputRegister, kCurtainRangeRegister, Access::kRead, Encoding::kUint16,
                 "beam_range", "m", Scaling::kMillimetres, 0, kUint16Max,
                 "from the light curtain's emitters to its receivers; saturates"},
    RegisterInfo{Area::kInputRegister, kBeamRegister, Access::kRead, Encoding::kUint16, "beam", "m",
                 Scaling::kMillimetres, 0, kUint16Max,
                 "each beam of the light curtain: distance from its emitter to the first object, "
                 "beam_range without one; 0 beyond the last beam",
                 kCurtainBeams},

    coil(kRunCoil, "run", "as the holding register"),
    coil(kDirectionCoil, "direction", "as the holding register"),
    coil(kEmergencyStopCoil, "estop",
         "1 engages the emergency stop and holds a fault, 0 releases it"),
    coil(kFaultResetCoil, "fault_reset",
         "1 clears a held fault unless its cause persists; reads 0"),

    input(kReadyInput, "ready", "no fault: run starts the belt"),
    input(kMovingInput, "moving", "the belt moves"),
    input(kAtSpeedInput, "at_speed", "running at the target speed"),
    input(kFaultInput, "fault", "fault_code is not 0"),
    input(kEmergencyStopInput, "estop_active", "the emergency stop is engaged"),
    input(kReverseInput, "reverse", "the belt moves backward"),
    input(kCurtainInput, "curtain", "the light curtain is broken: something is in a beam"),
    input(kPhotoEyeInput, "photo_eye_1",
          "something is in the beam; 0 if there is no such photo-eye"),
    input(kPhotoEyeInput + 1, "photo_eye_2", "the same for photo-eye 2"),
    input(kPhotoEyeInput + 2, "photo_eye_3", "the same for photo-eye 3"),
    input(kPhotoEyeInput + 3, "photo_eye_4", "the same for photo-eye 4"),
};

}  // namespace

std::span<const RegisterInfo> register_map() { return kMap; }

const RegisterInfo* find_register(Area area, std::uint16_t address) {
  for (const RegisterInfo& info : kMap) {
    const int offset = int{address} - int{info.address};
    if (info.area == area && offset >= 0 && offset < int{info.span()}) return &info;
  }
  return nullptr;
}

std::optional<std::string> check(const ConveyorScaling& scaling) {
  constexpr double kMin = 1e-3, kMax = 100;
  const double v = scaling.full_scale_m_s;
  if (std::isfinite(v) && v >= kMin && v <= kMax) return std::nullopt;
  return "full-scale belt speed " + std::to_string(v) +
         " m/s is not within 0.001 to 100 m/s (it is the speed that 32768 counts stand for)";
}

}  // namespace aprsim::modbus
