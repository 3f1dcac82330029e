#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "protocols/access.hpp"
#include "protocols/audit_log.hpp"
#include "protocols/connection_places.hpp"
#include "protocols/incident_source.hpp"
#include "protocols/refusal_sink.hpp"
#include "protocols/robot_port.hpp"
#include "protocols/state_files.hpp"
#include "protocols/tls.hpp"
#include "protocols/wire_trace.hpp"
#include "world/api/cell_event.hpp"
#include "world/api/duration_histogram.hpp"
#include "world/api/error.hpp"
#include "world/api/history.hpp"
#include "world/api/ports.hpp"
#include "world/api/snapshot_feed.hpp"
#include "world/api/virtual_time.hpp"

namespace aprsim::telemetry {

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

struct TelemetryStats {
  std::uint64_t accepted = 0;  ///< connections taken
  std::uint64_t refused = 0;   ///< connections closed at once: over the limit
  std::uint64_t open = 0;      ///< connections now
  std::uint64_t calls = 0;     ///< begun, streams included
  std::uint64_t failed = 0;    ///< of those that have ended: with another status than OK
  std::uint64_t streams = 0;   ///< of snapshots, now
  std::uint64_t samples = 0;   ///< that streams have sent
  std::uint64_t dropped = 0;   ///< samples that slow readers did not get
  api::DurationHistogram::Counts answer_times;  ///< of calls that are no streams
};

/// gRPC listener of package aprsim.v1: telemetry, control, health and reflection; and of
/// aprsim.crcl.v1: the robots.
///
/// Who has a token gives it as metadata "authorization: Bearer TOKEN". Answers only from the
/// latest snapshot. A slow stream reader loses samples and is told how many; it never holds up
/// the simulation or other clients. The health status of "" and of every service is SERVING while
/// the server runs, NOT_SERVING while the simulation has a problem().
class TelemetryServer {
 public:
  /// Sink and source must outlive the server.
  TelemetryServer(TelemetryOptions options, api::CommandSink& sink,
                  const api::SnapshotSource& source);
  ~TelemetryServer();
  TelemetryServer(const TelemetryServer&) = delete;
  TelemetryServer& operator=(const TelemetryServer&) = delete;

  /// Listens and serves on threads of its own; returns the bound port. Call once.
  /// Errors: kInvalidArgument for a bad address or rate, kUnavailable when the port is taken.
  [[nodiscard]] Result<std::uint16_t> start();

  /// Stops accepting, ends all streams and waiting calls with UNAVAILABLE, and cancels what is
  /// left at the deadline. Also without a start and more than once. Thread: not a gRPC callback.
  void stop(std::chrono::milliseconds deadline = std::chrono::milliseconds(500));

  /// Thread: any, between start() and stop().
  [[nodiscard]] TelemetryStats stats() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aprsim::telemetry
