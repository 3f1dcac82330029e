#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "protocols/access/access.hpp"
#include "protocols/access/audit_log.hpp"
#include "protocols/net/connection_places.hpp"
#include "protocols/net/tls.hpp"
#include "protocols/ports/incident_source.hpp"
#include "protocols/ports/refusal_sink.hpp"
#include "protocols/ports/robot_port.hpp"
#include "protocols/ports/state_files.hpp"
#include "protocols/record/wire_trace.hpp"
#include "world/api/ports/history.hpp"
#include "world/api/ports/snapshot_feed.hpp"
#include "world/api/ports/virtual_time.hpp"
#include "world/api/values/cell_event.hpp"

namespace aprsim::grpc_server {

/// Settings of the gRPC listener. The objects it points to outlive the server.
struct TelemetryOptions {
  std::string address = "127.0.0.1";  ///< numeric IPv4 or IPv6 address to listen on
  std::uint16_t port = 50051;         ///< 0 = any free port
  /// A connection without a place is logged and closed at once.
  protocols::ConnectionLimits limits;
  int max_streams = 32;         ///< snapshot streams at once; more get RESOURCE_EXHAUSTED
  double default_rate_hz = 20;  ///< of a stream that asks for 0
  double max_rate_hz = 1000;    ///< asking for more is INVALID_ARGUMENT
  /// Of streams of every step: what each may keep for a reader that is behind.
  std::size_t max_backlog_samples = 4096, max_backlog_bytes = std::size_t{8} << 20;
  int max_event_streams = 32;                       ///< at once; more get RESOURCE_EXHAUSTED
  std::chrono::milliseconds command_timeout{2000};  ///< for calls that carry no deadline
  std::chrono::milliseconds write_timeout{10000};   ///< a stream stuck in one write ends
  api::EndpointId endpoint = 0;                     ///< put on every command of this listener
  /// Step() passes it where "grpc" is declared to pace; null = the wall clock passes time.
  /// Outlives the server.
  api::VirtualTime* virtual_time = nullptr;
  api::History* history = nullptr;               ///< null = no past is kept; outlives the server
  protocols::StateFiles* state_files = nullptr;  ///< null = states stay where they are; outlives it
  api::SnapshotFeed* feed = nullptr;             ///< of every step; null = no such streams
  const api::EventSource* events = nullptr;      ///< of the cell; null = no such streams
  /// Who may what; null = whoever is on this machine all, others look.
  std::shared_ptr<protocols::Access> access = {};
  protocols::AuditLog* audit = nullptr;      ///< of commands; outlives the server; null = none
  std::shared_ptr<protocols::Tls> tls = {};  ///< null = nothing is encrypted
  std::vector<protocols::RobotPort*> robots = {};  ///< outlive the server
  std::string instance_id;  ///< names this process to clients; empty = random
  protocols::IncidentSource* incidents = nullptr;  ///< null = there are none; outlives the server
  protocols::WireTrace* trace = nullptr;       ///< hears of calls that command; outlives the server
  protocols::RefusalSink* refusals = nullptr;  ///< hears what is refused; outlives the server
};

}  // namespace aprsim::grpc_server
