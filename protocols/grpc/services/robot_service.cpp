#include "protocols/grpc/services/robot_service.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "crcl/messages.hpp"
#include "protocols/grpc/calls/call_peer.hpp"
#include "protocols/grpc/calls/rpc_status.hpp"
#include "protocols/grpc/services/robot_stream.hpp"

namespace aprsim::grpc_server {
namespace {

constexpr double kDefaultRateHz = 20, kMaxRateHz = 1000;

// Converts the unit of a message to that of a value, which counts from 0.
template <typename Unit, typename Stated>
std::optional<Unit> unit_of(bool stated, Stated unit) {
  if (!stated || unit == 0) return std::nullopt;
  return static_cast<Unit>(static_cast<int>(unit) - 1);
}

// One unary call, with a session of its own.
template <typename Response>
class SessionCall final : public grpc::ServerUnaryReactor, public protocols::RobotClient {
 public:
  explicit SessionCall(Response& response) : response_(response) {}

  /// Continues with the session, or finishes with the error.
  void begin(std::shared_ptr<SessionCall> self,
             Result<std::shared_ptr<protocols::RobotSession>> session,
             const std::function<void(protocols::RobotSession&)>& ask) {
    self_ = std::move(self);
    if (!session) return end(rpc_status(session.error()));
    session_ = *session;
    ask(*session_);
  }
  void refuse(std::shared_ptr<SessionCall> self, const grpc::Status& status) {
    self_ = std::move(self);
    end(status);
  }

  void on_taken() override {}
  void on_status(const crcl::Status& status) override {
    if constexpr (std::is_same_v<Response, crcl::v1::GetStatusResponse>) answer(status);
  }
  void on_over(const crcl::Status& status, bool replaced) override {
    if constexpr (std::is_same_v<Response, crcl::v1::ExecuteResponse>) {
      response_.set_replaced(replaced);
      answer(status);
    }
  }
  void on_end(const Error& reason) override { end(rpc_status(reason)); }

  void OnCancel() override { end(grpc::Status::CANCELLED); }
  void OnDone() override {
    // The session knows its client: neither may keep the other.
    if (const auto session = std::exchange(session_, nullptr)) session->close();
    self_.reset();
  }

 private:
  void answer(const crcl::Status& status) {
    if (ended_.exchange(true)) return;
    *response_.mutable_status() = crcl::to_message(status);
    Finish(grpc::Status::OK);
  }
  void end(const grpc::Status& status) {
    if (!ended_.exchange(true)) Finish(status);
  }

  Response& response_;
  std::atomic<bool> ended_{false};
  std::shared_ptr<protocols::RobotSession> session_;
  std::shared_ptr<SessionCall> self_;
};

crcl::CommandInstance get_status() {
  crcl::CommandInstance instance;
  instance.command.body = crcl::GetStatus{};
  return instance;
}

}  // namespace

RobotService::RobotService(const protocols::RobotPorts* ports, Refusal refusal)
    : ports_(ports), refusal_(std::move(refusal)) {}

Result<std::shared_ptr<protocols::RobotSession>> RobotService::open(
    const crcl::v1::SessionOptions& asked, const crcl::v1::ConfigureStatusReport* report,
    const grpc::CallbackServerContext& context,
    std::shared_ptr<protocols::RobotClient> client) const {
  const auto port = ports_ == nullptr ? nullptr : ports_->find(asked.robot());
  if (!port) {
    std::string names;
    if (ports_ != nullptr) {
      for (const auto& known : ports_->names()) names += (names.empty() ? "" : ", ") + known;
    }
    return fail(ErrorCode::kNotFound, "options.robot",
                fmt::format("the cell has no robot '{}', it has: {}", asked.robot(), names));
  }
  protocols::RobotSessionOptions options;
  options.peer = call_peer(context.peer()).address + " gRPC";
  options.length = unit_of<crcl::LengthUnit>(asked.has_length_unit(), asked.length_unit());
  options.angle = unit_of<crcl::AngleUnit>(asked.has_angle_unit(), asked.angle_unit());
  options.force = unit_of<crcl::ForceUnit>(asked.has_force_unit(), asked.force_unit());
  options.torque = unit_of<crcl::TorqueUnit>(asked.has_torque_unit(), asked.torque_unit());
  if (report != nullptr) {
    options.report = crcl::ConfigureStatusReport{
        report->report_joint_statuses(), report->report_pose_status(),
        report->report_gripper_status(), report->report_settings_status(),
        report->report_sensors_status(), report->report_guards_status()};
  }
  return port->open(std::move(options), std::move(client));
}

grpc::ServerBidiReactor<crcl::v1::ConnectRequest, crcl::v1::ConnectResponse>* RobotService::Connect(
    grpc::CallbackServerContext* context) {
  auto stream = std::make_shared<RobotStream>(*this, *context, refusal_(*context));
  stream->begin(stream);
  return stream.get();
}

grpc::ServerUnaryReactor* RobotService::Execute(grpc::CallbackServerContext* context,
                                                const crcl::v1::ExecuteRequest* request,
                                                crcl::v1::ExecuteResponse* response) {
  auto call = std::make_shared<SessionCall<crcl::v1::ExecuteResponse>>(*response);
  auto* reactor = call.get();
  if (const auto refused = refusal_(*context)) {
    call->refuse(call, *refused);
  } else if (request->command().command().has_get_status()) {
    call->refuse(call, {grpc::StatusCode::INVALID_ARGUMENT,
                        "command: GetStatus executes nothing; there is a call of that name"});
  } else {
    auto command = crcl::from_message(request->command());
    call->begin(call, open(request->options(), nullptr, *context, call),
                [&](protocols::RobotSession& session) { session.execute(std::move(command)); });
  }
  return reactor;
}

grpc::ServerUnaryReactor* RobotService::GetStatus(grpc::CallbackServerContext* context,
                                                  const crcl::v1::GetStatusRequest* request,
                                                  crcl::v1::GetStatusResponse* response) {
  auto call = std::make_shared<SessionCall<crcl::v1::GetStatusResponse>>(*response);
  auto* reactor = call.get();
  const auto* report = request->has_report() ? &request->report() : nullptr;
  call->begin(call, open(request->options(), report, *context, call),
              [](protocols::RobotSession& session) { session.send(get_status()); });
  return reactor;
}

grpc::ServerWriteReactor<crcl::v1::StreamStatusResponse>* RobotService::StreamStatus(
    grpc::CallbackServerContext* context, const crcl::v1::StreamStatusRequest* request) {
  auto stream = std::make_shared<StatusStream>();
  const double rate_hz = request->rate_hz() == 0 ? kDefaultRateHz : request->rate_hz();
  if (!std::isfinite(rate_hz) || rate_hz <= 0 || rate_hz > kMaxRateHz) {
    stream->begin(stream,
                  fail(ErrorCode::kInvalidArgument, "rate_hz",
                       fmt::format("{} is not above 0 and up to {} Hz", rate_hz, kMaxRateHz)),
                  {});
    return stream.get();
  }
  const auto* report = request->has_report() ? &request->report() : nullptr;
  // The lowest rate is one status an hour.
  const std::chrono::duration<double> period(std::min(1 / rate_hz, 3600.0));
  stream->begin(stream, open(request->options(), report, *context, stream),
                std::chrono::duration_cast<std::chrono::nanoseconds>(period));
  return stream.get();
}

}  // namespace aprsim::grpc_server
