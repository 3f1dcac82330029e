#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocols/access/access.hpp"
#include "protocols/access/audit_log.hpp"
#include "protocols/cameras/camera_server.hpp"
#include "protocols/crcl/crcl_server.hpp"
#include "protocols/grpc/grpc_server.hpp"
#include "protocols/modbus/modbus_server.hpp"
#include "protocols/simple_message/simple_message_server.hpp"
#include "protocols/vision/vision_server.hpp"
#include "protocols/web/web_server.hpp"
#include "server/config/memory_shares.hpp"
#include "server/journal/journal_stats.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/api/snapshot/solver_work.hpp"
#include "world/base/duration_histogram.hpp"

namespace aprsim::server {

/// Counts of refusals, TLS failures and audit records.
struct AccessSources {
  protocols::AccessCounts refused;
  std::vector<std::pair<std::string, std::uint64_t>> tls_failures;  ///< by wire
  protocols::AuditStats audit;
};

/// Limits and use of memory by part [bytes].
struct MemoryUse {
  MemoryShares shares;
  std::uint64_t journal_ring = 0, journal_queues = 0, history = 0, past_states = 0;
  std::uint64_t saved_states = 0, events = 0;
};

/// Values of all counters and gauges at one time.
struct MetricsSources {
  api::SnapshotPtr snapshot;
  bool ready = false;  ///< the simulation runs at the requested pace
  api::DurationHistogram::Counts step_times;
  api::SolverWork solver;
  std::size_t waiting_commands = 0;
  std::vector<std::pair<std::string, crcl_server::CrclServerStats>> crcl;  ///< by robot
  std::vector<std::pair<std::string, vision_server::VisionServerStats>> vision;
  std::vector<std::pair<std::string, camera_server::CameraServerStats>> cameras;  ///< by name
  std::vector<std::pair<std::string, simple_message::SimpleMessageStats>> simple_message;
  modbus_server::ModbusServerStats modbus;
  std::vector<std::pair<std::string, modbus_server::ModbusServerStats>> modbus_maps;  ///< by name
  std::vector<std::pair<std::string, modbus_server::ModbusServerStats>>
      modbus_secure;                             ///< with TLS, by listener
  std::optional<journal::JournalStats> journal;  ///< where the run is recorded
  grpc_server::TelemetryStats grpc;
  web::WebServerStats web;
  AccessSources access;
  MemoryUse memory;
};

/// All metrics of the daemon in Prometheus' text format, each with a HELP line. Thread: any.
[[nodiscard]] std::string metrics_text(const MetricsSources& sources);

}  // namespace aprsim::server
