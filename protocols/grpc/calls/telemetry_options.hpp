#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "protocols/grpc/calls/transfer_limits.hpp"
#include "protocols/net/listener_options.hpp"
#include "protocols/ports/camera_pictures.hpp"
#include "protocols/ports/incident_source.hpp"
#include "protocols/ports/robot_port.hpp"
#include "protocols/ports/state_files.hpp"
#include "world/api/ports/history.hpp"
#include "world/api/ports/move_previews.hpp"
#include "world/api/ports/snapshot_feed.hpp"
#include "world/api/values/cell_event.hpp"

namespace aprsim::grpc_server {

/// Settings of the gRPC listener. The objects it points to outlive the server. Step() passes
/// virtual time where "grpc" is declared to pace.
struct TelemetryOptions {
  protocols::ListenerOptions listener{.port = 50051,
                                      .drain_deadline = std::chrono::milliseconds(200)};
  int max_streams = 32;         ///< snapshot streams at once; more get RESOURCE_EXHAUSTED
  double default_rate_hz = 20;  ///< of a stream that asks for 0
  double max_rate_hz = 1000;    ///< asking for more is INVALID_ARGUMENT
  /// Largest backlog of each stream of every step.
  std::size_t max_backlog_samples = 4096, max_backlog_bytes = std::size_t{8} << 20;
  /// Limit of the backlogs of all these streams together; each gets an equal part.
  std::size_t max_backlogs_bytes = std::size_t{64} << 20;
  std::size_t max_memory_bytes = std::size_t{64} << 20;  ///< of gRPC's own buffers
  /// Limit of all messages that clients have not read; see UnreadAnswers.
  std::size_t max_unread_bytes = std::size_t{16} << 20;
  /// The same limit of pictures, whose messages are larger.
  std::size_t max_unread_image_bytes = std::size_t{64} << 20;
  int max_event_streams = 32;                       ///< at once; more get RESOURCE_EXHAUSTED
  int max_image_streams = 16;                       ///< at once; more get RESOURCE_EXHAUSTED
  std::chrono::milliseconds command_timeout{2000};  ///< for calls that carry no deadline
  std::chrono::milliseconds write_timeout{10000};   ///< a call stuck in one write ends
  api::History* history = nullptr;                  ///< null = no history; outlives the server
  api::MovePreviews* previews = nullptr;            ///< null = no previews; outlives the server
  protocols::StateFiles* state_files = nullptr;     ///< null = no import and export; outlives it
  TransferLimits transfers;                         ///< of states
  api::SnapshotFeed* feed = nullptr;                ///< of every step; null = no such streams
  const api::EventSource* events = nullptr;         ///< of the cell; null = no such streams
  const protocols::RobotPorts* robots = nullptr;    ///< null = none; outlives the server
  /// Whether the robots of a cell can be reached: a reset is confirmed then. Null = at once.
  std::function<bool(const api::CellDescription&)> listens = {};
  protocols::CameraPictures* cameras = nullptr;  ///< null = none; outlives the server
  std::string instance_id;                       ///< names this process to clients; empty = random
  protocols::IncidentSource* incidents = nullptr;  ///< null = there are none; outlives the server
};

}  // namespace aprsim::grpc_server
