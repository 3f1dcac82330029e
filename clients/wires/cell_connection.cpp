#include "clients/wires/cell_connection.hpp"

#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <google/protobuf/message.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/support/channel_arguments.h>

#include "aprsim/v1/camera_service.grpc.pb.h"
#include "aprsim/v1/control_service.grpc.pb.h"
#include "aprsim/v1/journal_service.grpc.pb.h"
#include "aprsim/v1/telemetry_service.grpc.pb.h"
#include "aprsim/v1/trajectory_service.grpc.pb.h"
#include "world/base/utf8.hpp"

namespace aprsim::client {
namespace {

constexpr auto kTransferTimeout = std::chrono::seconds(60);
constexpr auto kLongCall = std::chrono::hours(1);  // for steps and runs

v1::StepRequest step_request(std::uint64_t steps, std::span<const char* const> fields) {
  v1::StepRequest request;
  request.set_steps(steps);
  request.mutable_read_mask();
  for (const char* field : fields) request.mutable_read_mask()->add_paths(field);
  return request;
}

Failure failure_of(const grpc::Status& status, const std::string& address) {
  switch (status.error_code()) {
    case grpc::StatusCode::UNAVAILABLE:
      return {FailureKind::kConnection, fmt::format("cannot reach the cell by gRPC at {}: {}",
                                                    address, status.error_message())};
    case grpc::StatusCode::DEADLINE_EXCEEDED:
      return {FailureKind::kTimeout, fmt::format("no answer by gRPC from {} in time", address)};
    case grpc::StatusCode::UNAUTHENTICATED:
      return {FailureKind::kUnauthenticated, status.error_message()};
    default:
      break;
  }
  if (!status.error_message().empty()) return {FailureKind::kRefused, status.error_message()};
  return {FailureKind::kRefused,
          fmt::format("the daemon at {} refused the request without a reason (gRPC status {})",
                      address, static_cast<int>(status.error_code()))};
}

/// The first text of a request that is no UTF-8, which a message cannot carry.
std::optional<Failure> wrong_text(const google::protobuf::Message& message) {
  using google::protobuf::FieldDescriptor;
  const auto& reflection = *message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        auto wrong =
            wrong_text(field->is_repeated() ? reflection.GetRepeatedMessage(message, field, i)
                                            : reflection.GetMessage(message, field));
        if (wrong) return wrong;
      } else if (field->type() == FieldDescriptor::TYPE_STRING) {
        const std::string text = field->is_repeated()
                                     ? reflection.GetRepeatedString(message, field, i)
                                     : reflection.GetString(message, field);
        if (utf8::is_valid(text)) continue;
        return Failure{FailureKind::kUsage, fmt::format("{}: found \"{}\", expected UTF-8",
                                                        field->name(), utf8::valid(text))};
      }
    }
  }
  return std::nullopt;
}

std::shared_ptr<grpc::ChannelCredentials> credentials_of(const Endpoints& endpoints) {
  if (!endpoints.encryption) return grpc::InsecureChannelCredentials();
  grpc::SslCredentialsOptions options;
  options.pem_root_certs = endpoints.encryption->ca;
  options.pem_cert_chain = endpoints.encryption->certificate;
  options.pem_private_key = endpoints.encryption->key;
  return grpc::SslCredentials(options);
}

/// A channel that connects directly: http_proxy and its like are for web pages, and CRCL and Modbus
/// connect directly, too.
std::shared_ptr<grpc::Channel> channel_to(const std::string& address, const Endpoints& endpoints) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  return grpc::CreateCustomChannel(address, credentials_of(endpoints), arguments);
}

}  // namespace

struct CellConnection::Stubs {
  Stubs(const std::shared_ptr<grpc::Channel>& channel, std::string with_token,
        std::chrono::milliseconds with_timeout)
      : telemetry(channel),
        journal(channel),
        control(channel),
        cameras(channel),
        trajectories(channel),
        token(std::move(with_token)),
        timeout(with_timeout) {}

  void prepare(grpc::ClientContext& context) const {
    if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
  }

  /// One unary call: `method` of `service` with a deadline; absent = that of the connection.
  template <typename Response, typename Service, typename Request>
  Outcome<Response> call(Service& service,
                         grpc::Status (Service::*method)(grpc::ClientContext*, const Request&,
                                                         Response*),
                         const Request& request, const std::string& address,
                         std::optional<std::chrono::milliseconds> within = {}) const {
    if (auto wrong = wrong_text(request)) return tl::unexpected(*std::move(wrong));
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + within.value_or(timeout));
    prepare(context);
    Response response;
    const grpc::Status status = (service.*method)(&context, request, &response);
    if (!status.ok()) return tl::unexpected(failure_of(status, address));
    return response;
  }

  /// The response to a unary call that `begin` starts, within an hour; absent = cancelled.
  template <typename Response, typename Begin>
  Outcome<std::optional<Response>> call_until(const Begin& begin, const Cancelled& cancelled,
                                              const std::string& address) const {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + kLongCall);
    prepare(context);
    grpc::CompletionQueue queue;
    Response response;
    grpc::Status status;
    const auto reader = begin(&context, &queue);
    reader->Finish(&response, &status, nullptr);
    bool given_up = false;
    void* tag = nullptr;
    bool ok = false;
    while (queue.AsyncNext(&tag, &ok, std::chrono::system_clock::now() + kCancellationPeriod) ==
           grpc::CompletionQueue::TIMEOUT) {
      if (given_up || !is_cancelled(cancelled)) continue;
      given_up = true;
      context.TryCancel();
    }
    if (status.ok()) return response;
    if (given_up) return std::nullopt;
    return tl::unexpected(failure_of(status, address));
  }

  v1::TelemetryService::Stub telemetry;
  v1::JournalService::Stub journal;
  v1::ControlService::Stub control;
  v1::CameraService::Stub cameras;
  v1::TrajectoryService::Stub trajectories;
  const std::string token;
  const std::chrono::milliseconds timeout;  ///< of a call
};

namespace {

/// Reads until `show` returns false or the stream ends.
template <typename Response>
Outcome<void> read_all(grpc::ClientContext& context, grpc::ClientReader<Response>& reader,
                       const std::function<bool(const Response&)>& show,
                       const std::string& address) {
  Response response;
  while (reader.Read(&response)) {
    if (show(response)) continue;
    context.TryCancel();
    static_cast<void>(reader.Finish());  // cancelled, as asked
    return {};
  }
  const grpc::Status status = reader.Finish();
  if (!status.ok()) return tl::unexpected(failure_of(status, address));
  return {};
}

/// The next tag of the queue. `given_up` is set, and the call cancelled, once `cancelled` says
/// true.
bool next_tag(grpc::CompletionQueue& queue, grpc::ClientContext& context,
              const Cancelled& cancelled, bool& given_up) {
  void* tag = nullptr;
  bool ok = false;
  while (queue.AsyncNext(&tag, &ok, std::chrono::system_clock::now() + kCancellationPeriod) ==
         grpc::CompletionQueue::TIMEOUT) {
    if (given_up || !is_cancelled(cancelled)) continue;
    given_up = true;
    context.TryCancel();
  }
  return ok;
}

template <typename Response>
Outcome<v1::Receipt> receipt(const Outcome<Response>& response) {
  if (!response) return tl::unexpected(response.error());
  return response->receipt();
}

}  // namespace

CellConnection::CellConnection(const Endpoints& endpoints, std::chrono::milliseconds timeout)
    : address_(host_and_port(endpoints.host, endpoints.grpc)),
      stubs_(std::make_unique<Stubs>(channel_to(address_, endpoints), endpoints.token, timeout)) {}
CellConnection::~CellConnection() = default;
CellConnection::CellConnection(CellConnection&&) noexcept = default;

Outcome<v1::GetSnapshotResponse> CellConnection::status() {
  return stubs_->call(stubs_->telemetry, &v1::TelemetryService::Stub::GetSnapshot,
                      v1::GetSnapshotRequest(), address_);
}

Outcome<v1::Snapshot> CellConnection::snapshot() {
  auto response = status();
  if (!response) return tl::unexpected(response.error());
  return std::move(*response->mutable_snapshot());
}

Outcome<v1::CellDescription> CellConnection::cell() {
  auto response = stubs_->call(stubs_->telemetry, &v1::TelemetryService::Stub::GetCell,
                               v1::GetCellRequest(), address_);
  if (!response) return tl::unexpected(response.error());
  return std::move(*response->mutable_cell());
}

Outcome<void> CellConnection::stream(
    double rate_hz, const std::function<bool(const v1::StreamSnapshotsResponse&)>& show) {
  grpc::ClientContext context;
  stubs_->prepare(context);
  v1::StreamSnapshotsRequest request;
  request.set_rate_hz(rate_hz);
  const auto reader = stubs_->telemetry.StreamSnapshots(&context, request);
  return read_all(context, *reader, show, address_);
}

Outcome<void> CellConnection::events(
    const v1::StreamEventsRequest& request,
    const std::function<bool(const v1::StreamEventsResponse&)>& show) {
  if (auto wrong = wrong_text(request)) return tl::unexpected(*std::move(wrong));
  grpc::ClientContext context;
  stubs_->prepare(context);
  const auto reader = stubs_->telemetry.StreamEvents(&context, request);
  return read_all(context, *reader, show, address_);
}

Outcome<void> CellConnection::images(
    const v1::StreamImagesRequest& request,
    const std::function<bool(const v1::StreamImagesResponse&)>& show) {
  if (auto wrong = wrong_text(request)) return tl::unexpected(*std::move(wrong));
  grpc::ClientContext context;
  stubs_->prepare(context);
  const auto reader = stubs_->cameras.StreamImages(&context, request);
  return read_all(context, *reader, show, address_);
}

Outcome<void> CellConnection::follow(
    const v1::FollowJointTrajectoryRequest& request,
    const std::function<void(const v1::FollowJointTrajectoryResponse&)>& show,
    const Cancelled& cancelled) {
  if (auto wrong = wrong_text(request)) return tl::unexpected(*std::move(wrong));
  grpc::ClientContext context;
  stubs_->prepare(context);
  grpc::CompletionQueue queue;
  bool given_up = false;
  const auto reader =
      stubs_->trajectories.AsyncFollowJointTrajectory(&context, request, &queue, nullptr);
  bool open = next_tag(queue, context, cancelled, given_up);
  while (open) {
    v1::FollowJointTrajectoryResponse response;
    reader->Read(&response, nullptr);
    open = next_tag(queue, context, cancelled, given_up);
    if (open) show(response);
  }
  grpc::Status status;
  reader->Finish(&status, nullptr);
  next_tag(queue, context, cancelled, given_up);
  if (status.ok()) return {};
  if (given_up) return failed(FailureKind::kInterrupted, "cancelled");
  return tl::unexpected(failure_of(status, address_));
}

Outcome<v1::Receipt> CellConnection::pause() {
  return receipt(stubs_->call(stubs_->control, &v1::ControlService::Stub::Pause, v1::PauseRequest(),
                              address_));
}

Outcome<v1::Receipt> CellConnection::resume() {
  return receipt(stubs_->call(stubs_->control, &v1::ControlService::Stub::Resume,
                              v1::ResumeRequest(), address_));
}

Outcome<v1::Receipt> CellConnection::step(std::uint64_t steps, std::chrono::milliseconds timeout) {
  v1::StepRequest request;
  request.set_steps(steps);
  return receipt(
      stubs_->call(stubs_->control, &v1::ControlService::Stub::Step, request, address_, timeout));
}

Outcome<v1::Snapshot> CellConnection::step_and_read(std::uint64_t steps,
                                                    std::span<const char* const> fields,
                                                    std::chrono::milliseconds timeout) {
  const auto request = step_request(steps, fields);
  auto response =
      stubs_->call(stubs_->control, &v1::ControlService::Stub::Step, request, address_, timeout);
  if (!response) return tl::unexpected(response.error());
  return std::move(*response->mutable_snapshot());
}

Outcome<std::optional<v1::Snapshot>> CellConnection::step_and_read(
    std::uint64_t steps, std::span<const char* const> fields, const Cancelled& cancelled) {
  const auto request = step_request(steps, fields);
  auto response = stubs_->call_until<v1::StepResponse>(
      [&](auto* context, auto* queue) {
        return stubs_->control.AsyncStep(context, request, queue);
      },
      cancelled, address_);
  if (!response) return tl::unexpected(response.error());
  if (!*response) return std::nullopt;
  return std::move(*(*response)->mutable_snapshot());
}

Outcome<v1::Receipt> CellConnection::set_speed(std::optional<double> factor) {
  v1::SetSpeedRequest request;
  if (factor) {
    request.set_factor(*factor);
  } else {
    request.set_maximum(true);
  }
  return receipt(
      stubs_->call(stubs_->control, &v1::ControlService::Stub::SetSpeed, request, address_));
}

Outcome<v1::RunUntilResponse> CellConnection::run_until(const v1::RunUntilRequest& request,
                                                        const Cancelled& cancelled) {
  if (auto wrong = wrong_text(request)) return tl::unexpected(*std::move(wrong));
  auto response = stubs_->call_until<v1::RunUntilResponse>(
      [&](auto* context, auto* queue) {
        return stubs_->control.AsyncRunUntil(context, request, queue);
      },
      cancelled, address_);
  if (!response) return tl::unexpected(response.error());
  if (!*response) return failed(FailureKind::kInterrupted, "interrupted");
  return std::move(**response);
}

Outcome<v1::GetSceneResponse> CellConnection::scene() {
  return stubs_->call(stubs_->telemetry, &v1::TelemetryService::Stub::GetScene,
                      v1::GetSceneRequest(), address_);
}

Outcome<v1::SpawnBodyResponse> CellConnection::spawn_body(const v1::SpawnBodyRequest& request) {
  return stubs_->call(stubs_->control, &v1::ControlService::Stub::SpawnBody, request, address_);
}

Outcome<v1::MoveBodyResponse> CellConnection::move_body(const v1::MoveBodyRequest& request) {
  return stubs_->call(stubs_->control, &v1::ControlService::Stub::MoveBody, request, address_);
}

Outcome<v1::Receipt> CellConnection::remove_body(const std::string& name) {
  v1::RemoveBodyRequest request;
  request.set_name(name);
  return receipt(
      stubs_->call(stubs_->control, &v1::ControlService::Stub::RemoveBody, request, address_));
}

Outcome<v1::Receipt> CellConnection::set_scene_value(const std::string& path,
                                                     const std::string& value) {
  v1::SetSceneValueRequest request;
  request.set_path(path);
  request.set_value(value);
  return receipt(
      stubs_->call(stubs_->control, &v1::ControlService::Stub::SetSceneValue, request, address_));
}

Outcome<v1::Receipt> CellConnection::reset(std::optional<std::uint64_t> seed) {
  v1::ResetRequest request;
  if (seed) request.set_seed(*seed);
  return reset(request);
}

Outcome<v1::Receipt> CellConnection::reset(const v1::ResetRequest& request) {
  return receipt(
      stubs_->call(stubs_->control, &v1::ControlService::Stub::Reset, request, address_));
}

Outcome<v1::Receipt> CellConnection::save_state(const std::string& name) {
  v1::SaveStateRequest request;
  request.set_name(name);
  return receipt(
      stubs_->call(stubs_->control, &v1::ControlService::Stub::SaveState, request, address_));
}

Outcome<v1::Receipt> CellConnection::load_state(const std::string& name) {
  v1::LoadStateRequest request;
  request.set_name(name);
  return receipt(
      stubs_->call(stubs_->control, &v1::ControlService::Stub::LoadState, request, address_));
}

Outcome<v1::Receipt> CellConnection::delete_state(const std::string& name) {
  v1::DeleteStateRequest request;
  request.set_name(name);
  return receipt(
      stubs_->call(stubs_->control, &v1::ControlService::Stub::DeleteState, request, address_));
}

Outcome<v1::ListStatesResponse> CellConnection::list_states() {
  return stubs_->call(stubs_->control, &v1::ControlService::Stub::ListStates,
                      v1::ListStatesRequest{}, address_);
}

Outcome<std::string> CellConnection::export_state(const std::string& name) {
  v1::ExportStateRequest request;
  request.set_name(name);
  if (auto wrong = wrong_text(request)) return tl::unexpected(*std::move(wrong));
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kTransferTimeout);
  stubs_->prepare(context);
  const auto reader = stubs_->control.ExportState(&context, request);
  std::string bytes;
  for (v1::ExportStateResponse part; reader->Read(&part);) bytes += part.data();
  if (const auto status = reader->Finish(); !status.ok()) {
    return tl::unexpected(failure_of(status, address_));
  }
  return bytes;
}

Outcome<v1::ImportStateResponse> CellConnection::import_state(const std::string& name,
                                                              const std::string& bytes) {
  constexpr std::size_t kPart = std::size_t{32} << 10;
  v1::ImportStateRequest request;
  request.set_name(name);
  if (auto wrong = wrong_text(request)) return tl::unexpected(*std::move(wrong));
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kTransferTimeout);
  stubs_->prepare(context);
  v1::ImportStateResponse response;
  const auto writer = stubs_->control.ImportState(&context, &response);
  for (std::size_t at = 0; at < bytes.size() || at == 0; at += kPart) {
    request.set_data(bytes.substr(at, kPart));
    // It fails when the daemon has refused; the status says why.
    if (!writer->Write(request)) break;
  }
  writer->WritesDone();
  if (const auto status = writer->Finish(); !status.ok()) {
    return tl::unexpected(failure_of(status, address_));
  }
  return response;
}

Outcome<v1::Receipt> CellConnection::set_signal(const std::string& device,
                                                const std::string& signal, double value) {
  v1::SetSignalsRequest request;
  v1::SignalSetting& setting = *request.add_settings();
  setting.set_device(device);
  setting.set_signal(signal);
  setting.set_value(value);
  return receipt(
      stubs_->call(stubs_->control, &v1::ControlService::Stub::SetSignals, request, address_));
}

Outcome<v1::SetIntruderResponse> CellConnection::set_intruder(
    const std::optional<v1::Intruder>& intruder) {
  v1::SetIntruderRequest request;
  if (intruder) *request.mutable_intruder() = *intruder;
  return stubs_->call(stubs_->control, &v1::ControlService::Stub::SetIntruder, request, address_);
}

Outcome<v1::InjectFaultResponse> CellConnection::inject_fault(
    const v1::InjectFaultRequest& request) {
  return stubs_->call(stubs_->control, &v1::ControlService::Stub::InjectFault, request, address_);
}

Outcome<v1::Receipt> CellConnection::end_fault(std::uint64_t id) {
  v1::EndFaultRequest request;
  request.set_id(id);
  return receipt(
      stubs_->call(stubs_->control, &v1::ControlService::Stub::EndFault, request, address_));
}

Outcome<v1::Receipt> CellConnection::report_event(const std::string& event) {
  v1::ReportEventRequest request;
  request.set_event(event);
  return receipt(
      stubs_->call(stubs_->control, &v1::ControlService::Stub::ReportEvent, request, address_));
}

Outcome<void> CellConnection::incident(
    double last_s, const std::function<bool(const v1::GetIncidentResponse&)>& take) {
  grpc::ClientContext context;
  stubs_->prepare(context);
  v1::GetIncidentRequest request;
  const auto nanos = std::llround(last_s * 1e9);
  request.mutable_last()->set_seconds(nanos / 1'000'000'000);
  request.mutable_last()->set_nanos(static_cast<std::int32_t>(nanos % 1'000'000'000));
  const auto reader = stubs_->journal.GetIncident(&context, request);
  return read_all(context, *reader, take, address_);
}

}  // namespace aprsim::client
