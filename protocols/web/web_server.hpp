#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "protocols/web/viewer/web_options.hpp"
#include "world/api/ports/ports.hpp"
#include "world/base/result.hpp"

/// The web page and its WebSocket.
namespace aprsim::web {

/// Serves the page over HTTP from a table of files. Sends each viewer, over a WebSocket, the latest
/// snapshot at its requested rate, and the traffic and registers that it watches. Accepts commands
/// and jogs from viewers with permission. Keeps faults and commands for viewers that connect later.
/// Accepts WebSockets from its own page only. GET /incident?last=SECONDS returns the last part of
/// the run as a journal file. For operators:
/// /metrics; /healthz, 200 while this thread answers; /readyz, 503 with the reason while the
/// simulation or another part has a problem(). One thread.
class WebServer {
 public:
  /// Keeps references to both; they must outlive the server.
  WebServer(WebServerOptions options, api::CommandSink& sink, const api::SnapshotSource& source);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// Reads the files, listens and starts the thread; returns the port. Without the page's files, a
  /// notice is served instead. Errors name address, port and cause. Call it once.
  [[nodiscard]] Result<std::uint16_t> start();
  /// Ends jogs, closes all viewers and connections, and joins. Idempotent.
  void stop();

  [[nodiscard]] std::size_t open() const;  ///< current connections; thread: any
  /// Thread: the server's, as in the calls of its options.
  [[nodiscard]] WebServerStats stats() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aprsim::web
