#pragma once

#include "aprsim/v1/telemetry_service.grpc.pb.h"
#include "protocols/telemetry/call_gate.hpp"
#include "protocols/telemetry/stream_hub.hpp"
#include "protocols/telemetry/telemetry_server.hpp"

namespace aprsim::telemetry {

/// aprsim.v1.TelemetryService on the callback API. Never waits.
class TelemetryService final : public v1::TelemetryService::CallbackService {
 public:
  TelemetryService(const TelemetryOptions& options, const api::SnapshotSource& source,
                   StreamHub& hub, const CallGate& gate);

  grpc::ServerWriteReactor<v1::StreamSnapshotsResponse>* StreamSnapshots(
      grpc::CallbackServerContext* context, const v1::StreamSnapshotsRequest* request) override;
  grpc::ServerUnaryReactor* GetSnapshot(grpc::CallbackServerContext* context,
                                        const v1::GetSnapshotRequest* request,
                                        v1::GetSnapshotResponse* response) override;
  grpc::ServerUnaryReactor* GetCell(grpc::CallbackServerContext* context,
                                    const v1::GetCellRequest* request,
                                    v1::GetCellResponse* response) override;

 private:
  [[nodiscard]] Result<double> rate(double asked_hz) const;

  const TelemetryOptions& options_;
  const api::SnapshotSource& source_;
  StreamHub& hub_;
  const CallGate& gate_;
};

}  // namespace aprsim::telemetry
