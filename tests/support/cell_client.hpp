#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

#include <grpcpp/grpcpp.h>

#include "aprsim/v1/control_service.grpc.pb.h"
#include "aprsim/v1/telemetry_service.grpc.pb.h"
#include "tests/support/patience.hpp"

namespace aprsim::test {

/// gRPC access to a running daemon. Every failed call throws std::runtime_error.
class CellClient {
 public:
  explicit CellClient(std::uint16_t port)
      : channel_(grpc::CreateChannel("127.0.0.1:" + std::to_string(port),
                                     grpc::InsecureChannelCredentials())),
        telemetry(v1::TelemetryService::NewStub(channel_)),
        control(v1::ControlService::NewStub(channel_)) {}

  v1::Snapshot snapshot() {
    v1::GetSnapshotResponse response;
    grpc::ClientContext context;
    require(telemetry->GetSnapshot(&context, {}, &response));
    return response.snapshot();
  }

  v1::CellDescription cell() {
    v1::GetCellResponse response;
    grpc::ClientContext context;
    require(telemetry->GetCell(&context, {}, &response));
    return response.cell();
  }

  v1::StepResponse step(std::uint64_t steps) {
    v1::StepRequest request;
    request.set_steps(steps);
    v1::StepResponse response;
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(60));
    require(control->Step(&context, request, &response));
    return response;
  }

  /// Waits until a snapshot satisfies `condition`; throws with `what` at the deadline.
  v1::Snapshot wait_for(const std::function<bool(const v1::Snapshot&)>& condition,
                        const std::string& what,
                        std::chrono::seconds deadline = std::chrono::seconds(20)) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + kPatience * deadline);
    v1::StreamSnapshotsRequest request;
    request.set_rate_hz(200);
    auto stream = telemetry->StreamSnapshots(&context, request);
    v1::StreamSnapshotsResponse response;
    while (stream->Read(&response)) {
      if (condition(response.snapshot())) {
        context.TryCancel();
        return response.snapshot();
      }
    }
    throw std::runtime_error("waited in vain for " + what);
  }

  static void require(const grpc::Status& status) {
    if (!status.ok()) throw std::runtime_error(status.error_message());
  }

 private:
  std::shared_ptr<grpc::Channel> channel_;

 public:
  std::unique_ptr<v1::TelemetryService::Stub> telemetry;
  std::unique_ptr<v1::ControlService::Stub> control;
};

}  // namespace aprsim::test
