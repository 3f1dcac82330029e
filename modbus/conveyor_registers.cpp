#include "modbus/conveyor_registers.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::modbus {
namespace {

/// Nearest integer within [low, high]; 0 for NaN.
long clamped(double value, double low, double high) {
  if (std::isnan(value)) return 0;
  return std::lround(std::clamp(value, low, high));
}

template <typename T>
T& at(std::array<T, kAddressCount>& area, std::uint16_t address) {
  return area[static_cast<std::size_t>(address - kFirstAddress)];
}

std::uint16_t word(double value) { return static_cast<std::uint16_t>(clamped(value, 0, 65535)); }

void put32(std::array<std::uint16_t, kAddressCount>& area, std::uint16_t address,
           std::uint32_t value) {
  at(area, address) = static_cast<std::uint16_t>(value >> 16);
  at(area, static_cast<std::uint16_t>(address + 1)) = static_cast<std::uint16_t>(value & 0xFFFF);
}

/// Signed speed that the drive's inputs set, within the belt's limit.
double target_speed(const ConveyorReadings& r) {
  if (!r.run) return 0;
  const double magnitude = std::min(r.speed_setting_m_s, r.max_speed_m_s);
  return r.forward ? magnitude : -magnitude;
}

void encode_bits(const ConveyorReadings& r, const ConveyorScaling& scaling, RegisterImage& image) {
  at(image.coils, kRunCoil) = r.run;
  at(image.coils, kDirectionCoil) = r.forward == scaling.one_is_forward;
  at(image.coils, kEmergencyStopCoil) = r.emergency_stop;
  at(image.coils, kFaultResetCoil) = 0;

  at(image.discrete, kReadyInput) = r.present && r.fault == FaultCode::kNone;
  at(image.discrete, kMovingInput) = r.speed_m_s != 0;
  at(image.discrete, kAtSpeedInput) = drive_state(r) == DriveState::kAtSpeed;
  at(image.discrete, kFaultInput) = r.fault != FaultCode::kNone;
  at(image.discrete, kEmergencyStopInput) = r.emergency_stop;
  at(image.discrete, kReverseInput) = r.speed_m_s < 0;
  for (std::uint16_t i = 0; i < kPhotoEyes; ++i) {
    at(image.discrete, static_cast<std::uint16_t>(kPhotoEyeInput + i)) = r.photo_eyes[i].broken;
  }
}

void encode_light_curtain(const LightCurtainReadings& curtain, RegisterImage& image) {
  at(image.discrete, kCurtainInput) = curtain.broken;
  at(image.input, kCurtainBeamsRegister) = curtain.beams;
  at(image.input, kCurtainRangeRegister) = word(curtain.range_m * 1e3);
  for (std::uint16_t i = 0; i < kCurtainBeams; ++i) {
    at(image.input, static_cast<std::uint16_t>(kBeamRegister + i)) =
        i < curtain.beams ? word(curtain.distance_m[i] * 1e3) : std::uint16_t{0};
  }
}

ConveyorWrite decode_coils(const Request& request, const ConveyorScaling& scaling) {
  ConveyorWrite write;
  for (std::uint16_t i = 0; i < request.quantity; ++i) {
    const int address = request.address + i;
    const bool on = request.bit(i);
    if (address == kRunCoil) write.run = on;
    if (address == kDirectionCoil) write.forward = on == scaling.one_is_forward;
    if (address == kEmergencyStopCoil) write.emergency_stop = on;
    if (address == kFaultResetCoil) write.fault_reset = on;
  }
  return write;
}

}  // namespace

std::uint16_t speed_counts(double speed_m_s, const ConveyorScaling& scaling) {
  return static_cast<std::uint16_t>(
      clamped(speed_m_s / scaling.m_s_per_count(), 0, kSpeedFullScaleCounts));
}

std::uint16_t signed_speed_counts(double speed_m_s, const ConveyorScaling& scaling) {
  return static_cast<std::uint16_t>(clamped(speed_m_s / scaling.m_s_per_count(), -32768, 32767));
}

std::uint32_t position_counts(double travel_m) {
  const double counts = travel_m / kMetresPerPositionCount;
  // Beyond this a double cannot resolve counts, and the cast below would overflow.
  if (!(std::abs(counts) < 9e15)) return 0;
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(std::llround(counts)));
}

DriveState drive_state(const ConveyorReadings& readings) {
  // A hundredth of the count of the default scaling: far below what any register can show.
  constexpr double kTolerance = 1e-7;
  if (!readings.present) return DriveState::kAbsent;
  if (readings.fault != FaultCode::kNone) return DriveState::kFault;
  const double target = target_speed(readings);
  if (std::abs(readings.speed_m_s - target) > kTolerance) return DriveState::kRamping;
  return std::abs(target) <= kTolerance ? DriveState::kStandstill : DriveState::kAtSpeed;
}

void encode(const ConveyorReadings& readings, const ConveyorScaling& scaling,
            RegisterImage& image) {
  ConveyorReadings r = readings.present ? readings : ConveyorReadings{};
  r.fault = readings.fault;
  at(image.holding, kRunRegister) = r.run ? 1 : 0;
  at(image.holding, kDirectionRegister) = r.forward == scaling.one_is_forward ? 1 : 0;
  at(image.holding, kSpeedRegister) = speed_counts(r.speed_setting_m_s, scaling);

  at(image.input, kActualSpeedRegister) = signed_speed_counts(r.speed_m_s, scaling);
  at(image.input, kTargetSpeedRegister) = signed_speed_counts(target_speed(r), scaling);
  at(image.input, kDriveStateRegister) = static_cast<std::uint16_t>(drive_state(r));
  at(image.input, kFaultCodeRegister) = static_cast<std::uint16_t>(r.fault);
  put32(image.input, kPositionRegister, position_counts(r.travel_m));
  put32(image.input, kTimeStampRegister, static_cast<std::uint32_t>(readings.time_ms & 0xFFFFFFFF));
  at(image.input, kMaxSpeedRegister) = word(r.max_speed_m_s / scaling.m_s_per_count());
  at(image.input, kMotorCurrentRegister) = word(r.motor_current_a * 1e3);
  at(image.input, kLoadRegister) = word(r.load_kg * 1e2);
  for (std::uint16_t i = 0; i < kPhotoEyes; ++i) {
    at(image.input, static_cast<std::uint16_t>(kItemCountRegister + i)) =
        static_cast<std::uint16_t>(r.photo_eyes[i].count & 0xFFFF);
  }
  encode_bits(r, scaling, image);
  encode_light_curtain(readings.light_curtain, image);
}

Checked<ConveyorWrite> decode_write(const Request& request, const ConveyorScaling& scaling) {
  if (request.is_coil_write()) return decode_coils(request, scaling);
  ConveyorWrite write;
  for (std::uint16_t i = 0; i < request.quantity; ++i) {
    const auto address = static_cast<std::uint16_t>(request.address + i);
    const RegisterInfo* info = find_register(Area::kHoldingRegister, address);
    if (info == nullptr) continue;
    const std::uint16_t value = request.word(i);
    if (value < info->min || value > info->max) {
      return tl::unexpected(ExceptionCode::kIllegalDataValue);
    }
    if (address == kRunRegister) write.run = value == 1;
    if (address == kDirectionRegister) write.forward = (value == 1) == scaling.one_is_forward;
    if (address == kSpeedRegister) write.speed_m_s = value * scaling.m_s_per_count();
  }
  return write;
}

}  // namespace aprsim::modbus
