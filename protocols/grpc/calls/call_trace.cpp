#include "protocols/grpc/calls/call_trace.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <google/protobuf/message.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/interceptor.h>
#include <grpcpp/support/slice.h>

#include "protocols/grpc/calls/call_peer.hpp"

namespace aprsim::grpc_server {
namespace {

using grpc::experimental::InterceptionHookPoints;
using protocols::WireContent;

/// Calls that change something: all of a service, or one.
constexpr std::array<std::string_view, 3> kCommanding{"/aprsim.v1.ControlService/",
                                                      "/aprsim.crcl.v1.RobotService/Connect",
                                                      "/aprsim.crcl.v1.RobotService/Execute"};

std::string bytes_of(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  std::string bytes;
  if (!buffer.Dump(&slices).ok()) return bytes;
  for (const grpc::Slice& slice : slices) {
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  return bytes;
}

/// Traces one call.
class Tracing final : public grpc::experimental::Interceptor {
 public:
  Tracing(protocols::WireTrace& trace, const api::SnapshotSource& source,
          grpc::experimental::ServerRpcInfo* info)
      : trace_(trace), source_(source), info_(info), method_(info->method()) {}

  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_MESSAGE)) {
      // All messages of these services are generated from their descriptions.
      const auto* message = static_cast<google::protobuf::Message*>(methods->GetRecvMessage());
      if (message != nullptr) record(WireContent::kReceived, message->SerializeAsString());
    }
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_MESSAGE)) {
      const grpc::ByteBuffer* message = methods->GetSerializedSendMessage();
      if (message != nullptr) record(WireContent::kSent, bytes_of(*message));
    }
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS)) {
      const grpc::Status status = methods->GetSendStatus();
      if (!status.ok()) {
        record(WireContent::kSent, {},
               "status " + std::to_string(status.error_code()) + ": " + status.error_message());
      }
    }
    methods->Proceed();
  }

 private:
  void record(WireContent content, std::string data, std::string text = {}) {
    if (!connection_) {
      CallPeer peer = call_peer(info_->server_context()->peer());
      connection_ = std::make_shared<const protocols::WireConnection>(protocols::WireConnection{
          protocols::WireKind::kGrpc, "grpc", peer.connection, std::move(peer.address)});
    }
    protocols::record(trace_, source_,
                      {.connection = connection_,
                       .content = content,
                       .data = std::move(data),
                       .method = method_,
                       .text = std::move(text)});
  }

  protocols::WireTrace& trace_;
  const api::SnapshotSource& source_;
  grpc::experimental::ServerRpcInfo* const info_;
  const std::string method_;
  std::shared_ptr<const protocols::WireConnection> connection_;
};

class TraceFactory final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  TraceFactory(protocols::WireTrace& trace, const api::SnapshotSource& source)
      : trace_(trace), source_(source) {}
  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* info) override {
    const std::string_view method(info->method() == nullptr ? "" : info->method());
    const bool commands = std::ranges::any_of(
        kCommanding, [&](std::string_view calls) { return method.starts_with(calls); });
    // gRPC takes it over; null = none for this call.
    return commands ? new Tracing(trace_, source_, info) : nullptr;
  }

 private:
  protocols::WireTrace& trace_;
  const api::SnapshotSource& source_;
};

}  // namespace

std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> trace_of_calls(
    protocols::WireTrace& trace, const api::SnapshotSource& source) {
  return std::make_unique<TraceFactory>(trace, source);
}

}  // namespace aprsim::grpc_server
