#include "protocols/grpc/services/telemetry_service.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "protocols/grpc/calls/rpc_status.hpp"
#include "protocols/grpc/streams/snapshot_stream.hpp"
#include "protocols/messages/control_response.hpp"
#include "protocols/messages/write_message.hpp"

namespace aprsim::grpc_server {
namespace {

/// Refuses a stream before it begins.
template <typename Response>
class RefusedStream final : public grpc::ServerWriteReactor<Response> {
 public:
  explicit RefusedStream(const grpc::Status& status) { this->Finish(status); }
  void OnDone() override { delete this; }
};

}  // namespace

TelemetryService::TelemetryService(const TelemetryOptions& options,
                                   const api::SnapshotSource& source, StreamHub& hub,
                                   EventHub& events, const CallGate& gate)
    : options_(options),
      source_(source),
      hub_(hub),
      events_(events),
      gate_(gate),
      views_(options.instance_id) {}

Result<double> TelemetryService::rate(const v1::StreamSnapshotsRequest& request) const {
  const double asked_hz = request.rate_hz();
  if (request.every_step()) {
    if (asked_hz == 0) return 0;
    return fail(ErrorCode::kInvalidArgument, "rate_hz",
                fmt::format("{} is not 0, as it must be with every_step", asked_hz));
  }
  if (asked_hz == 0) return options_.default_rate_hz;
  if (!std::isfinite(asked_hz) || asked_hz < 0 || asked_hz > options_.max_rate_hz) {
    return fail(ErrorCode::kInvalidArgument, "rate_hz",
                fmt::format("{} is not within 0 and {} Hz", asked_hz, options_.max_rate_hz));
  }
  // The lowest rate is one sample an hour; the period then fits its type.
  return std::max(asked_hz, 1.0 / 3600);
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* TelemetryService::StreamSnapshots(
    grpc::CallbackServerContext* context, const grpc::ByteBuffer* bytes) {
  using Refused = RefusedStream<grpc::ByteBuffer>;
  if (const auto refused = gate_.refusal(*context)) return new Refused(*refused);
  v1::StreamSnapshotsRequest request;
  grpc::ByteBuffer copy(*bytes);  // of references; reading takes them
  const grpc::Status read =
      grpc::SerializationTraits<v1::StreamSnapshotsRequest>::Deserialize(&copy, &request);
  if (!read.ok()) {
    return new Refused({grpc::StatusCode::INVALID_ARGUMENT, "it is not a StreamSnapshotsRequest"});
  }
  const auto rate_hz = rate(request);
  if (!rate_hz) return new Refused(rpc_status(rate_hz.error()));
  auto view = protocols::SnapshotView::parse(request.read_mask(), request.entities(),
                                             *source_.latest()->cell);
  if (!view) return new Refused(rpc_status(view.error()));
  auto stream = std::make_shared<SnapshotStream>(
      *context, hub_, views_.share(*std::move(view)), *rate_hz,
      BacklogLimits{options_.max_backlog_samples, options_.max_backlog_bytes});
  stream->self = stream;
  if (const auto status = hub_.add(stream); !status.ok()) {
    stream->self.reset();
    return new Refused(status);
  }
  return stream.get();
}

Result<EventWish> TelemetryService::wish(const v1::StreamEventsRequest& request) const {
  const std::uint64_t latest = options_.events->after(0, 0).latest;
  EventWish wish{.after = request.has_after() ? request.after() : latest,
                 .allow_gap = request.allow_gap(),
                 .past_only = request.past_only()};
  if (wish.after > latest) {
    return fail(ErrorCode::kUnreachable, "after",
                fmt::format("{} is more than the latest number, {}; numbers start anew with the "
                            "daemon",
                            wish.after, latest));
  }
  auto kinds = protocols::event_kinds(request.kinds());
  if (!kinds) return tl::unexpected(kinds.error());
  wish.kinds = *std::move(kinds);
  wish.names.assign(request.names().begin(), request.names().end());
  return wish;
}

grpc::ServerWriteReactor<v1::StreamEventsResponse>* TelemetryService::StreamEvents(
    grpc::CallbackServerContext* context, const v1::StreamEventsRequest* request) {
  using Refused = RefusedStream<v1::StreamEventsResponse>;
  if (const auto refused = gate_.refusal(*context)) return new Refused(*refused);
  if (options_.events == nullptr) {
    return new Refused({grpc::StatusCode::UNIMPLEMENTED, "there are no events here"});
  }
  auto wanted = wish(*request);
  if (!wanted) return new Refused(rpc_status(wanted.error()));
  auto stream =
      std::make_shared<EventStream>(*context, events_, *options_.events, *std::move(wanted));
  stream->self = stream;
  if (const auto status = events_.add(stream); !status.ok()) {
    stream->self.reset();
    return new Refused(status);
  }
  stream->begin();
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
  const api::SnapshotPtr snapshot = source_.latest();
  const auto written =
      protocols::write_response(*snapshot, *request, options_.instance_id, *response);
  if (!written) {
    reactor->Finish(rpc_status(written.error()));
    return reactor;
  }
  response->set_problem(source_.problem());
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
  protocols::write_response(*source_.latest(), *response);
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

grpc::ServerUnaryReactor* TelemetryService::GetScene(grpc::CallbackServerContext* context,
                                                     const v1::GetSceneRequest* /*request*/,
                                                     v1::GetSceneResponse* response) {
  auto* reactor = context->DefaultReactor();
  if (const auto refused = gate_.refusal(*context)) {
    reactor->Finish(*refused);
    return reactor;
  }
  protocols::write_response(*source_.latest(), *response);
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

}  // namespace aprsim::grpc_server
