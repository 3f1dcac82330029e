#pragma once

#include <string>

#include "world/base/result.hpp"

/// Errors as gRPC statuses.
namespace aprsim::protocols {

/// The number of an error's code in gRPC.
[[nodiscard]] constexpr int status_code(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidArgument:
      return 3;
    case ErrorCode::kNotFound:
      return 5;
    case ErrorCode::kFailedPrecondition:
      return 9;
    case ErrorCode::kUnreachable:
      return 11;  // OUT_OF_RANGE
    case ErrorCode::kUnimplemented:
      return 12;
    case ErrorCode::kUnavailable:
      return 14;
  }
  return 13;  // INTERNAL
}
/// That of a command whose effect a reset or a fault of the world has ended.
inline constexpr int kAbortedStatus = 10;

/// "field: message".
[[nodiscard]] inline std::string status_text(const Error& error) {
  return error.field.empty() ? error.message : error.field + ": " + error.message;
}

}  // namespace aprsim::protocols
