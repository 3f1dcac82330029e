#pragma once

#include <grpcpp/support/status.h>

#include "protocols/messages/status_code.hpp"
#include "world/base/result.hpp"

namespace aprsim::grpc_server {

/// Converts an error to a gRPC status: "field: message" with the corresponding code.
[[nodiscard]] inline grpc::Status rpc_status(const Error& error) {
  return {static_cast<grpc::StatusCode>(protocols::status_code(error.code)),
          protocols::status_text(error)};
}

}  // namespace aprsim::grpc_server
