#pragma once

#include "modbus/request.hpp"
#include "world/base/result.hpp"

namespace aprsim::conveyor {

/// The exception that tells why the simulation has refused a command.
[[nodiscard]] inline modbus::ExceptionCode exception_for(const Error& error) {
  switch (error.code) {
    case ErrorCode::kUnavailable:
      return modbus::ExceptionCode::kServerDeviceBusy;
    case ErrorCode::kInvalidArgument:
      return modbus::ExceptionCode::kIllegalDataValue;
    default:
      return modbus::ExceptionCode::kServerDeviceFailure;
  }
}

}  // namespace aprsim::conveyor
