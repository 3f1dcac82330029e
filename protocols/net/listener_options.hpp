#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "protocols/access/access.hpp"
#include "protocols/access/audit_log.hpp"
#include "protocols/net/connection_limiter.hpp"
#include "protocols/net/tls.hpp"
#include "protocols/ports/refusal_sink.hpp"
#include "protocols/ports/wire_trace.hpp"
#include "world/api/ports/virtual_time.hpp"

namespace aprsim::protocols {

/// Settings common to all listeners. Each server's own options contain them.
/// The objects that they point to outlive the listener.
struct ListenerOptions {
  /// Numeric IPv4 or IPv6; "localhost" = 127.0.0.1 and ::1, where the machine has IPv6.
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;        ///< 0 = any free port
  ConnectionLimits limits = {};  ///< a connection beyond them is refused
  /// Networks or addresses that are served, "192.168.1.0/24"; connections of others are closed at
  /// once. Empty = everybody is served.
  std::vector<std::string> allow = {};
  /// Time in which stop() lets pending replies be sent.
  std::chrono::milliseconds drain_deadline{500};
  api::EndpointId endpoint = 0;  ///< stamped on every command of this listener
  /// Permissions of callers, for gRPC and the page; null = this machine may do everything, others
  /// may read.
  std::shared_ptr<Access> access = {};
  AuditLog* audit = nullptr;        ///< records commands of gRPC and the page; null = none is kept
  std::shared_ptr<Tls> tls = {};    ///< encrypts gRPC and the page; null = nothing is encrypted
  WireTrace* trace = nullptr;       ///< records everything on the wire; null = nothing is recorded
  RefusalSink* refusals = nullptr;  ///< is notified of rejections; null = nobody is
  api::VirtualTime* virtual_time = nullptr;  ///< null = the wall clock passes time
};

}  // namespace aprsim::protocols
