#include "modbus/conveyor_registers.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::modbus {
namespace {

/// Nearest integer within [low, high]; 0 for what is not a number.
long clamped(double value, double low, double high) {
  if (std::isnan(value)) return 0;
  return std::lround(std::clamp(value, low, high));
}

std::uint16_t& at(std::array<std::uint16_t, kAddressCount>& area, std::uint16_t address) {
  return area[static_cast<std::size_t>(address - kFirstAddress)];
}

void put32(std::array<std::uint16_t, kAddressCount>& area, std::uint16_t address,
           std::uint32_t value) {
  at(area, address) = static_cast<std::uint16_t>(value >> 16);
  at(area, static_cast<std::uint16_t>(address + 1)) = static_cast<std::uint16_t>(value & 0xFFFF);
}

/// Signed speed that the drive's inputs ask for, within what the belt can do.
double target_speed(const ConveyorReadings& r) {
  if (!r.run) return 0;
  const double magnitude = std::min(r.speed_setting_m_s, r.max_speed_m_s);
  return r.forward ? magnitude : -magnitude;
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
  // Beyond this a double no longer resolves counts, and the cast below would overflow.
  if (!(std::abs(counts) < 9e15)) return 0;
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(std::llround(counts)));
}

DriveState drive_state(const ConveyorReadings& readings) {
  // A hundredth of the count of the default scaling: far below what any register can show.
  constexpr double kTolerance = 1e-7;
  if (!readings.present) return DriveState::kAbsent;
  const double target = target_speed(readings);
  if (std::abs(readings.speed_m_s - target) > kTolerance) return DriveState::kRamping;
  return std::abs(target) <= kTolerance ? DriveState::kStandstill : DriveState::kAtSpeed;
}

void encode(const ConveyorReadings& readings, const ConveyorScaling& scaling,
            RegisterImage& image) {
  const ConveyorReadings r = readings.present ? readings : ConveyorReadings{};
  at(image.holding, kRunRegister) = r.run ? 1 : 0;
  at(image.holding, kDirectionRegister) = r.forward == scaling.one_is_forward ? 1 : 0;
  at(image.holding, kSpeedRegister) = speed_counts(r.speed_setting_m_s, scaling);

  at(image.input, kActualSpeedRegister) = signed_speed_counts(r.speed_m_s, scaling);
  at(image.input, kTargetSpeedRegister) = signed_speed_counts(target_speed(r), scaling);
  at(image.input, kDriveStateRegister) = static_cast<std::uint16_t>(drive_state(r));
  at(image.input, kFaultCodeRegister) = readings.fault ? 1 : 0;
  put32(image.input, kPositionRegister, position_counts(r.travel_m));
  put32(image.input, kTimeStampRegister, static_cast<std::uint32_t>(readings.time_ms & 0xFFFFFFFF));
  at(image.input, kMaxSpeedRegister) =
      static_cast<std::uint16_t>(clamped(r.max_speed_m_s / scaling.m_s_per_count(), 0, 65535));
}

Checked<ConveyorWrite> decode_write(const Request& request, const ConveyorScaling& scaling) {
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
