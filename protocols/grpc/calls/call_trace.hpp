#pragma once

#include <memory>

#include <grpcpp/support/server_interceptor.h>

#include "protocols/record/connection_trace.hpp"

namespace aprsim::grpc_server {

/// For ServerBuilder::experimental().SetInterceptorCreators(): traces every commanding
/// call, its messages and its status. Trace and source outlive the server.
[[nodiscard]] std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> trace_of_calls(
    protocols::WireTrace& trace, const api::SnapshotSource& source);

}  // namespace aprsim::grpc_server
