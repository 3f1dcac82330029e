#pragma once

#include "aprsim/v1/telemetry_service.grpc.pb.h"
#include "protocols/grpc/calls/call_gate.hpp"
#include "protocols/grpc/calls/telemetry_options.hpp"
#include "protocols/grpc/streams/event_stream.hpp"
#include "protocols/grpc/streams/shared_view.hpp"
#include "protocols/grpc/streams/stream_hub.hpp"

namespace aprsim::grpc_server {

/// aprsim.v1.TelemetryService on the callback API. Never waits. Snapshots are streamed as bytes, so
/// that streams share serialized ones.
class TelemetryService final : public v1::TelemetryService::WithRawCallbackMethod_StreamSnapshots<
                                   v1::TelemetryService::WithCallbackMethod_StreamEvents<
                                       v1::TelemetryService::WithCallbackMethod_GetSnapshot<
                                           v1::TelemetryService::WithCallbackMethod_GetCell<
                                               v1::TelemetryService::WithCallbackMethod_GetScene<
                                                   v1::TelemetryService::Service>>>>> {
 public:
  TelemetryService(const TelemetryOptions& options, const api::SnapshotSource& source,
                   StreamHub& hub, EventHub& events, const CallGate& gate);

  grpc::ServerWriteReactor<grpc::ByteBuffer>* StreamSnapshots(
      grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) override;
  grpc::ServerWriteReactor<v1::StreamEventsResponse>* StreamEvents(
      grpc::CallbackServerContext* context, const v1::StreamEventsRequest* request) override;
  grpc::ServerUnaryReactor* GetSnapshot(grpc::CallbackServerContext* context,
                                        const v1::GetSnapshotRequest* request,
                                        v1::GetSnapshotResponse* response) override;
  grpc::ServerUnaryReactor* GetCell(grpc::CallbackServerContext* context,
                                    const v1::GetCellRequest* request,
                                    v1::GetCellResponse* response) override;
  grpc::ServerUnaryReactor* GetScene(grpc::CallbackServerContext* context,
                                     const v1::GetSceneRequest* request,
                                     v1::GetSceneResponse* response) override;

 private:
  /// 0 = every step.
  [[nodiscard]] Result<double> rate(const v1::StreamSnapshotsRequest& request) const;
  [[nodiscard]] Result<EventWish> wish(const v1::StreamEventsRequest& request) const;

  const TelemetryOptions& options_;
  const api::SnapshotSource& source_;
  StreamHub& hub_;
  EventHub& events_;
  const CallGate& gate_;
  SharedViews views_;
};

}  // namespace aprsim::grpc_server
