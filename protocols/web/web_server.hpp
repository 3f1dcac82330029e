#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "modbus/register_map.hpp"
#include "protocols/access.hpp"
#include "protocols/audit_log.hpp"
#include "protocols/connection_places.hpp"
#include "protocols/incident_source.hpp"
#include "protocols/refusal_sink.hpp"
#include "protocols/tls.hpp"
#include "protocols/web/program_runner.hpp"
#include "protocols/web/visual_description.hpp"
#include "protocols/wire_tap.hpp"
#include "protocols/wire_trace.hpp"
#include "world/api/cell_description.hpp"
#include "world/api/duration_histogram.hpp"
#include "world/api/error.hpp"
#include "world/api/history.hpp"
#include "world/api/ports.hpp"

/// The web page and its WebSocket.
namespace aprsim::web {

/// One listener of the daemon, as the page shows it.
struct ListenerCount {
  std::string name;
  std::uint16_t port = 0;
  std::uint64_t clients = 0;
};

/// Connections beyond the limit that are told so at a time; those beyond are closed at once.
inline constexpr std::size_t kMaxTurnedAway = 256;

struct WebServerStats {
  std::uint64_t accepted = 0;  ///< connections taken
  std::uint64_t refused = 0;   ///< connections without a place
  std::uint64_t open = 0;      ///< connections now
  std::uint64_t requests = 0;  ///< over HTTP, and of pages over their WebSockets
  std::uint64_t failed = 0;    ///< of these: answered with an error
  std::uint64_t skipped = 0;   ///< snapshots that slow viewers did not get
  api::DurationHistogram::Counts answer_times;
};

struct WebServerOptions {
  std::string bind_address = "127.0.0.1";  ///< a numeric IPv4 or IPv6 address
  std::uint16_t port = 8080;               ///< 0 = any free port
  /// A connection without a place gets a page that says so, and 503.
  protocols::ConnectionLimits limits{.at_once = 32};
  std::size_t max_viewers = 24;  ///< WebSockets among them; a further one gets 503
  double max_rate_hz = 60;       ///< of snapshots
  bool control = true;           ///< false: no viewer may command
  std::string read_only;         ///< not empty: nor may any for this reason
  /// Who may what; null = whoever is on this machine all, others look.
  std::shared_ptr<protocols::Access> access = {};
  protocols::AuditLog* audit = nullptr;      ///< of commands; outlives the server; null = none
  std::shared_ptr<protocols::Tls> tls = {};  ///< null = nothing is encrypted
  std::vector<std::string> hosts;  ///< host names of the page besides addresses and localhost
  std::string assets;              ///< directory of the page's files
  std::vector<std::pair<std::string, std::string>> models;  ///< robot name, description file
  /// Of a cell by its description; asked once a scene. Thread: the web server's.
  std::function<VisualDescription(const api::CellDescription&)> visual;
  std::string version;
  modbus::ConveyorScaling scaling;  ///< of the registers shown
  api::EndpointId endpoint = 0;     ///< stamped on every command
  std::chrono::milliseconds jog_timeout{400};
  /// stop() lets closing handshakes go on for at most so long.
  std::chrono::milliseconds drain_deadline{300};
  protocols::WireTap* crcl_tap = nullptr;  ///< both outlive the server; may be null
  protocols::WireTap* modbus_tap = nullptr;
  protocols::IncidentSource* incidents = nullptr;  ///< null = there are none; outlives the server
  protocols::WireTrace* trace = nullptr;       ///< hears of viewers' commands; outlives the server
  protocols::RefusalSink* refusals = nullptr;  ///< hears what is refused; outlives the server
  ProgramRunner* programs = nullptr;           ///< outlives the server; null = pages start none
  api::History* history = nullptr;             ///< outlives the server; null = no past is kept
  std::function<std::vector<ListenerCount>()> listeners;  ///< called on the server's thread
  /// The text behind /metrics, in Prometheus' format; called on the server's thread. None: 404.
  std::function<std::string()> metrics = {};
};

/// Serves the page over HTTP from a table of files, and to each viewer, over a WebSocket, the
/// latest snapshot at the rate it asks for, besides traffic and registers that it watches. Takes
/// commands and jogs from viewers that may. Keeps what goes wrong in the cell, and what was asked
/// for, for viewers that come later. Connects browsers from its own page only.
/// GET /incident?last=SECONDS gives the latest of the run as a journal file. For operators:
/// /metrics; /healthz, 200 while this thread answers; /readyz, 503 with the reason while the
/// simulation has a problem(). One thread.
class WebServer {
 public:
  /// Keeps references to both; they must outlive the server.
  WebServer(WebServerOptions options, api::CommandSink& sink, const api::SnapshotSource& source);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// Reads the files, listens and starts the thread; returns the port. Without the page's files a
  /// notice takes their place. Fails with the address, port and cause. Once only.
  [[nodiscard]] Result<std::uint16_t> start();
  /// Ends jogs, says goodbye to viewers, closes everything and joins. Again: nothing.
  void stop();

  [[nodiscard]] std::size_t open() const;  ///< connections now; thread: any
  /// Thread: the server's, as in the calls of its options.
  [[nodiscard]] WebServerStats stats() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aprsim::web
