#include "protocols/grpc/calls/call_gate.hpp"

#include <utility>

#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>
#include <grpcpp/support/interceptor.h>
#include <spdlog/spdlog.h>

#include "protocols/access/call_roles.hpp"
#include "protocols/net/connection_limiter.hpp"

namespace aprsim::grpc_server {
namespace {

using grpc::experimental::InterceptionHookPoints;
using grpc::experimental::InterceptorBatchMethods;

/// The token after "Bearer" in a call's metadata; absent = the call has no credentials. Other
/// schemes give an empty token.
template <typename Metadata>
std::optional<std::string_view> token_in(const Metadata& metadata) {
  constexpr std::string_view kScheme = "Bearer ";
  const auto found = metadata.find("authorization");
  if (found == metadata.end()) return std::nullopt;
  const std::string_view value(found->second.data(), found->second.size());
  return value.starts_with(kScheme) ? value.substr(kScheme.size()) : "";
}

grpc::Status status_of(const protocols::Refusal& refusal) {
  using Kind = protocols::Refusal::Kind;
  const auto code = refusal.kind == Kind::kUnauthenticated ? grpc::StatusCode::UNAUTHENTICATED
                    : refusal.kind == Kind::kPermission    ? grpc::StatusCode::PERMISSION_DENIED
                                                           : grpc::StatusCode::RESOURCE_EXHAUSTED;
  return {code, refusal.message};
}

/// The request as the audit log shows it.
std::string json_of(void* request) {
  // All services here have protobuf messages.
  const auto& message = *static_cast<const google::protobuf::Message*>(request);
  const std::size_t size = message.ByteSizeLong();
  if (size > protocols::AuditLog::kMaxRequest) return std::to_string(size) + " bytes";
  std::string text;
  (void)google::protobuf::util::MessageToJsonString(message, &text);
  return text;
}

/// Authorizes one call.
class Judging final : public grpc::experimental::Interceptor {
 public:
  Judging(CallGate& gate, grpc::experimental::ServerRpcInfo& info)
      : gate_(gate),
        context_(*info.server_context()),
        method_(info.method()),
        stream_(info.type() != grpc::experimental::ServerRpcInfo::Type::UNARY) {}
  ~Judging() override { gate_.forget(context_, call_); }

  void Intercept(InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_INITIAL_METADATA)) {
      call_ = gate_.judge(context_, method_, token_in(*methods->GetRecvInitialMetadata()));
    }
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_MESSAGE))
      heard(*methods);
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS))
      ended(*methods);
    methods->Proceed();
  }

 private:
  void heard(InterceptorBatchMethods& methods) {
    if (call_ == nullptr || !call_->command || methods.GetRecvMessage() == nullptr) return;
    request_ = json_of(methods.GetRecvMessage());
    // Each message of a stream is a command, which ends when others follow.
    if (stream_ && !call_->refusal) gate_.audit(*call_, std::exchange(request_, {}), "");
  }

  void ended(InterceptorBatchMethods& methods) {
    if (call_ == nullptr) return;
    grpc::Status status = methods.GetSendStatus();
    if (call_->refusal) {
      if (status.ok()) spdlog::error("grpc: {} does not check its caller", call_->method);
      status = *call_->refusal;
      methods.ModifySendStatus(status);
    }
    gate_.ended(*call_, status);
    if (!call_->command) return;
    gate_.audit(*call_, std::move(request_), status.ok() ? "ok" : status.error_message());
  }

  CallGate& gate_;
  const grpc::ServerContextBase& context_;
  const char* const method_;
  const bool stream_;
  std::shared_ptr<const CallGate::Call> call_;
  std::string request_;
};

class JudgingFactory final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit JudgingFactory(CallGate& gate) : gate_(gate) {}
  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* info) override {
    // gRPC takes it over.
    return new Judging(gate_, *info);
  }

 private:
  CallGate& gate_;
};

}  // namespace

std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> CallGate::interceptor() {
  return std::make_unique<JudgingFactory>(*this);
}

std::shared_ptr<const CallGate::Call> CallGate::judge(const grpc::ServerContextBase& context,
                                                      const char* method,
                                                      std::optional<std::string_view> token) {
  Call call;
  call.method = method;
  if (call.method.starts_with('/')) call.method.erase(0, 1);
  const protocols::Role needed = protocols::role_needed(call.method);
  ConnectedClient client = clients_.of(context.peer());
  call.peer = std::move(client.peer);
  call.command = needed > protocols::Role::kView;
  if (needed > protocols::Role::kNone) {
    const protocols::Caller caller =
        access_.identify(protocols::host_of(call.peer), {token, std::move(client.certificate)});
    call.identity = caller.text();
    if (const auto refusal = access_.refusal(caller, call.method, needed)) {
      call.refusal = status_of(*refusal);
      log(call.peer + " is refused: " + refusal->message);
    }
  }
  const std::lock_guard lock(mutex_);
  return calls_[&context] = std::make_shared<const Call>(std::move(call));
}

std::optional<grpc::Status> CallGate::refusal(const grpc::CallbackServerContext& context) const {
  const std::lock_guard lock(mutex_);
  const auto found = calls_.find(&context);
  if (found == calls_.end())
    return grpc::Status(grpc::StatusCode::INTERNAL, "the call was not authorized");
  return found->second->refusal;
}

void CallGate::audit(const Call& call, std::string request, std::string outcome) const {
  if (audit_ == nullptr) return;
  audit_->write({.wire = "grpc",
                 .peer = call.peer,
                 .identity = call.identity,
                 .command = call.method,
                 .request = std::move(request),
                 .outcome = std::move(outcome)});
}

void CallGate::ended(const Call& call, const grpc::Status& status) const {
  // The cell reports its own errors.
  const bool bad = call.command && status.error_code() == grpc::StatusCode::INVALID_ARGUMENT;
  if (refusals_ == nullptr || (!bad && !call.refusal)) return;
  refusals_->refused("grpc", call.method + " of " + call.peer + ": " + status.error_message());
}

void CallGate::forget(const grpc::ServerContextBase& context,
                      const std::shared_ptr<const Call>& call) {
  const std::lock_guard lock(mutex_);
  const auto found = calls_.find(&context);
  if (found != calls_.end() && found->second == call) calls_.erase(found);
}

void CallGate::log(const std::string& line) {
  const std::lock_guard lock(log_mutex_);
  log_.warn(line);
}

}  // namespace aprsim::grpc_server
