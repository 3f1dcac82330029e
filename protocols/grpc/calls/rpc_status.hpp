#pragma once

#include <string>

#include <grpcpp/support/status.h>

#include "world/base/result.hpp"

namespace aprsim::grpc_server {

/// Converts an error to a gRPC status: "field: message" with the corresponding code.
[[nodiscard]] inline grpc::Status rpc_status(const Error& error) {
  const auto code = [&] {
    switch (error.code) {
      case ErrorCode::kInvalidArgument:
        return grpc::StatusCode::INVALID_ARGUMENT;
      case ErrorCode::kNotFound:
        return grpc::StatusCode::NOT_FOUND;
      case ErrorCode::kUnreachable:
        return grpc::StatusCode::OUT_OF_RANGE;
      case ErrorCode::kFailedPrecondition:
        return grpc::StatusCode::FAILED_PRECONDITION;
      case ErrorCode::kUnavailable:
        return grpc::StatusCode::UNAVAILABLE;
      case ErrorCode::kUnimplemented:
        return grpc::StatusCode::UNIMPLEMENTED;
    }
    return grpc::StatusCode::INTERNAL;
  }();
  return {code, error.field.empty() ? error.message : error.field + ": " + error.message};
}

}  // namespace aprsim::grpc_server
