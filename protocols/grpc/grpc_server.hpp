#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

#include "protocols/grpc/calls/telemetry_options.hpp"
#include "world/api/ports/ports.hpp"
#include "world/base/duration_histogram.hpp"
#include "world/base/result.hpp"

namespace aprsim::grpc_server {

struct TelemetryStats {
  std::uint64_t accepted = 0;                   ///< connections
  std::uint64_t refused = 0;                    ///< connections closed at once: over the limit
  std::uint64_t open = 0;                       ///< connections now
  std::uint64_t calls = 0;                      ///< started, streams included
  std::uint64_t failed = 0;                     ///< ended with another status than OK
  std::uint64_t streams = 0;                    ///< of snapshots, now
  std::uint64_t samples = 0;                    ///< that streams have sent
  std::uint64_t dropped = 0;                    ///< samples that slow readers did not receive
  api::DurationHistogram::Counts answer_times;  ///< of calls that are no streams
};

/// gRPC listener of package aprsim.v1: telemetry, control, health and reflection; and of
/// aprsim.crcl.v1: the robots.
///
/// A client sends its token as metadata "authorization: Bearer TOKEN". Answers only from the
/// latest snapshot. A slow stream reader loses samples and receives their number; it never delays
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

}  // namespace aprsim::grpc_server
