#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include <grpcpp/server_context.h>
#include <grpcpp/support/server_interceptor.h>

#include "protocols/access/access.hpp"
#include "protocols/access/audit_log.hpp"
#include "protocols/grpc/calls/connected_clients.hpp"
#include "protocols/net/limited_log.hpp"
#include "protocols/ports/refusal_sink.hpp"

namespace aprsim::grpc_server {

/// Authorizes every call before its service runs: compares the caller's role with the one that the
/// method needs. A service queries refusal() first, and does nothing if there is one; the caller
/// then receives the refusal as status. Commands are written to the audit log. Thread: any.
class CallGate {
 public:
  /// All must outlive it. `audit` and `refusals` may be null.
  CallGate(protocols::Access& access, const ConnectedClients& clients, protocols::AuditLog* audit,
           protocols::RefusalSink* refusals)
      : access_(access), clients_(clients), audit_(audit), refusals_(refusals) {}

  /// For ServerBuilder::experimental().SetInterceptorCreators(). The gate outlives the server.
  [[nodiscard]] std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>
  interceptor();

  /// The refusal of a call; absent = it is permitted.
  [[nodiscard]] std::optional<grpc::Status> refusal(
      const grpc::CallbackServerContext& context) const;

  struct Call {
    std::string method;  ///< without the slash before it
    std::string peer, identity;
    std::optional<grpc::Status> refusal;
    bool command = false;  ///< needs more than the role view
  };

  // For the interceptor.
  [[nodiscard]] std::shared_ptr<const Call> judge(const grpc::ServerContextBase& context,
                                                  const char* method,
                                                  std::optional<std::string_view> token);
  void audit(const Call& call, std::string request, std::string outcome) const;
  /// Records the outcome of a call, a caller's error included.
  void ended(const Call& call, const grpc::Status& status) const;
  void forget(const grpc::ServerContextBase& context, const std::shared_ptr<const Call>& call);

 private:
  void log(const std::string& line);

  protocols::Access& access_;
  const ConnectedClients& clients_;
  protocols::AuditLog* const audit_;
  protocols::RefusalSink* const refusals_;
  mutable std::mutex mutex_;
  std::map<const grpc::ServerContextBase*, std::shared_ptr<const Call>> calls_;
  std::mutex log_mutex_;
  protocols::LimitedLog log_{"grpc"};
};

}  // namespace aprsim::grpc_server
