#include "clients/wires/conveyor_state.hpp"

#include <cstddef>
#include <cstdint>

namespace aprsim::client {
namespace {

using modbus::DriveState;
using modbus::FaultCode;

std::size_t index(std::uint16_t address) {
  return static_cast<std::size_t>(address - modbus::kFirstAddress);
}

std::uint32_t word32(const modbus::RegisterImage& image, std::uint16_t address) {
  const std::uint32_t high = image.input[index(address)];
  return high << 16U | image.input[index(address) + 1];
}

}  // namespace

ConveyorState conveyor_state(const modbus::RegisterImage& image,
                             const modbus::ConveyorScaling& scaling) {
  const auto input = [&](std::uint16_t address) { return image.input[index(address)]; };
  const auto bit = [&](std::uint16_t address) { return image.discrete[index(address)] != 0; };
  const auto signed_speed = [&](std::uint16_t address) {
    return static_cast<std::int16_t>(input(address)) * scaling.m_s_per_count();
  };
  ConveyorState out;
  out.drive = static_cast<DriveState>(input(modbus::kDriveStateRegister));
  out.target_speed_m_s = signed_speed(modbus::kTargetSpeedRegister);
  out.ready = bit(modbus::kReadyInput);
  modbus::ConveyorReadings& r = out.readings;
  r.present = out.drive != DriveState::kAbsent;
  r.run = image.holding[index(modbus::kRunRegister)] != 0;
  r.forward = (image.holding[index(modbus::kDirectionRegister)] != 0) == scaling.one_is_forward;
  r.speed_setting_m_s = image.holding[index(modbus::kSpeedRegister)] * scaling.m_s_per_count();
  r.speed_m_s = signed_speed(modbus::kActualSpeedRegister);
  r.travel_m = static_cast<std::int32_t>(word32(image, modbus::kPositionRegister)) *
               modbus::kMetresPerPositionCount;
  r.max_speed_m_s = input(modbus::kMaxSpeedRegister) * scaling.m_s_per_count();
  r.time_ms = word32(image, modbus::kTimeStampRegister);
  r.fault = static_cast<FaultCode>(input(modbus::kFaultCodeRegister));
  r.emergency_stop = bit(modbus::kEmergencyStopInput);
  r.motor_current_a = input(modbus::kMotorCurrentRegister) * 1e-3;
  r.load_kg = input(modbus::kLoadRegister) * 1e-2;
  for (std::uint16_t i = 0; i < modbus::kPhotoEyes; ++i) {
    r.photo_eyes[i] = {bit(static_cast<std::uint16_t>(modbus::kPhotoEyeInput + i)),
                       input(static_cast<std::uint16_t>(modbus::kItemCountRegister + i))};
  }
  r.light_curtain.beams = input(modbus::kCurtainBeamsRegister);
  r.light_curtain.range_m = input(modbus::kCurtainRangeRegister) * 1e-3;
  r.light_curtain.broken = bit(modbus::kCurtainInput);
  return out;
}

}  // namespace aprsim::client
