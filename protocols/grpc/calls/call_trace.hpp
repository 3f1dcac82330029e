#pragma once

#include <memory>

#include <grpcpp/support/server_interceptor.h>

#include "protocols/record/connection_trace.hpp"

namespace aprsim::grpc_server {

/// For ServerBuilder::experimental().SetInterceptorCreators(): tells the trace of every call that
/// commands, its messages and how it ended. Trace and source outlive the server.
[[nodiscard]] std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> trace_of_calls(
    protocols::WireTrace& trace, const api::SnapshotSource& source);

}  // namespace aprsim::grpc_server
