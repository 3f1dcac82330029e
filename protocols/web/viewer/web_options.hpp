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
#include "protocols/net/listener_options.hpp"
#include "protocols/ports/incident_source.hpp"
#include "protocols/ports/program_runner.hpp"
#include "protocols/record/wire_tap.hpp"
#include "protocols/web/topics/listener_count.hpp"
#include "protocols/web/topics/visual_description.hpp"
#include "world/api/description/cell_description.hpp"
#include "world/api/ports/history.hpp"
#include "world/base/duration_histogram.hpp"

namespace aprsim::web {

/// Connections beyond the limit that are told so at a time; those beyond are closed at once.
inline constexpr std::size_t kMaxRejected = 256;

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
  /// A connection without a place gets a page that says so, and 503.
  protocols::ListenerOptions listener{
      .port = 8080, .limits = {.at_once = 32}, .drain_deadline = std::chrono::milliseconds(300)};
  std::size_t max_viewers = 24;    ///< WebSockets among them; a further one gets 503
  double max_rate_hz = 60;         ///< of snapshots
  bool control = true;             ///< false: no viewer may command
  std::string read_only;           ///< not empty: nor may any for this reason
  std::vector<std::string> hosts;  ///< host names of the page besides addresses and localhost
  std::string assets;              ///< directory of the page's files
  std::string documents;           ///< directory of the site under /docs; may be missing
  std::vector<std::pair<std::string, std::string>> models;  ///< robot name, description file
  /// Shapes of a cell by its description; asked once a scene. Thread: the web server's.
  std::function<VisualDescription(const api::CellDescription&)> visual;
  std::string version;
  modbus::ConveyorScaling scaling;  ///< of the registers shown
  std::chrono::milliseconds jog_timeout{400};
  protocols::WireTap* crcl_tap = nullptr;  ///< both outlive the server; may be null
  protocols::WireTap* modbus_tap = nullptr;
  protocols::IncidentSource* incidents = nullptr;  ///< null = there are none; outlives the server
  ProgramRunner* programs = nullptr;               ///< outlives the server; null = pages start none
  api::History* history = nullptr;                 ///< outlives the server; null = no past is kept
  std::function<std::vector<ListenerCount>()> listeners;  ///< called on the server's thread
  /// The text behind /metrics, in Prometheus' format; called on the server's thread. None: 404.
  std::function<std::string()> metrics = {};
};

}  // namespace aprsim::web
