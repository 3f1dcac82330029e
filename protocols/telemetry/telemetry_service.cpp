#include "protocols/telemetry/telemetry_service.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "protocols/messages/write_message.hpp"
#include "protocols/telemetry/field_mask.hpp"
#include "protocols/telemetry/rpc_status.hpp"
#include "protocols/telemetry/snapshot_stream.hpp"

namespace aprsim::telemetry {
namespace {

/// A stream that is refused before it begins.
class RefusedStream final : public grpc::ServerWriteReactor<v1::StreamSnapshotsResponse> {
 public:
  explicit RefusedStream(const grpc::Status& status) { Finish(status); }
  void OnDone() override { delete this; }
};

}  // namespace

TelemetryService::TelemetryService(const TelemetryOptions& options,
                                   const api::SnapshotSource& source, StreamHub& hub,
                                   const CallGate& gate)
    : options_(options), source_(source), hub_(hub), gate_(gate) {}

Result<double> TelemetryService::rate(double asked_hz) const {
  if (asked_hz == 0) return options_.default_rate_hz;
  if (!std::isfinite(asked_hz) || asked_hz < 0 || asked_hz > options_.max_rate_hz) {
    return fail(ErrorCode::kInvalidArgument, "rate_hz",
                fmt::format("{} is not within 0 and {} Hz", asked_hz, options_.max_rate_hz));
  }
  // A sample an hour is the slowest that makes sense; it keeps the period within its type.
  return std::max(asked_hz, 1.0 / 3600);
}

grpc::ServerWriteReactor<v1::StreamSnapshotsResponse>* TelemetryService::StreamSnapshots(
    grpc::CallbackServerContext* context, const v1::StreamSnapshotsRequest* request) {
  if (const auto refused = gate_.refusal(*context)) return new RefusedStream(*refused);
  const auto rate_hz = rate(request->rate_hz());
  if (!rate_hz) return new RefusedStream(rpc_status(rate_hz.error()));
  auto mask = SnapshotMask::parse(request->read_mask());
  if (!mask) return new RefusedStream(rpc_status(mask.error()));
  auto stream = std::make_shared<SnapshotStream>(*context, hub_, options_.instance_id, *rate_hz,
                                                 std::move(*mask));
  if (const auto status = hub_.add(stream); !status.ok()) return new RefusedStream(status);
  stream->self = stream;
  return stream.get();
}

grpc::ServerUnaryReactor* TelemetryService::GetSnapshot(grpc::CallbackServerContext* context,
                                                        const v1::GetSnapshotRequest* request,
                                                        v1::GetSnapshotResponse* response) {
  auto* reactor = context->DefaultReactor();
  if (const auto refused = gate_.refusal(*context)) {
    reactor->Finish(*refused);
    return reactor;
  }
  const auto mask = SnapshotMask::parse(request->read_mask());
  if (!mask) {
    reactor->Finish(rpc_status(mask.error()));
    return reactor;
  }
  protocols::write_message(*source_.latest(), options_.instance_id, *response->mutable_snapshot());
  response->set_problem(source_.problem());
  mask->trim(*response->mutable_snapshot());
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

grpc::ServerUnaryReactor* TelemetryService::GetCell(grpc::CallbackServerContext* context,
                                                    const v1::GetCellRequest* /*request*/,
                                                    v1::GetCellResponse* response) {
  auto* reactor = context->DefaultReactor();
  if (const auto refused = gate_.refusal(*context)) {
    reactor->Finish(*refused);
    return reactor;
  }
  const api::SnapshotPtr snapshot = source_.latest();
  protocols::write_message(*snapshot->cell, *response->mutable_cell());
  response->set_epoch(snapshot->epoch);
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

}  // namespace aprsim::telemetry
