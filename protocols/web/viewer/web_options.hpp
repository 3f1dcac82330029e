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
#include "protocols/ports/camera_pictures.hpp"
#include "protocols/ports/incident_source.hpp"
#include "protocols/ports/program_runner.hpp"
#include "protocols/ports/scenario_drafts.hpp"
#include "protocols/ports/scene_drafts.hpp"
#include "protocols/record/wire_tap.hpp"
#include "protocols/web/topics/listener_count.hpp"
#include "protocols/web/topics/visual_description.hpp"
#include "world/api/description/cell_description.hpp"
#include "world/api/ports/history.hpp"
#include "world/api/ports/move_previews.hpp"
#include "world/base/duration_histogram.hpp"

namespace aprsim::web {

/// Number of rejected connections that get a page with the reason; further ones are closed.
inline constexpr std::size_t kMaxRejected = 256;

struct WebServerStats {
  std::uint64_t accepted = 0;  ///< accepted connections
  std::uint64_t refused = 0;   ///< rejected connections
  std::uint64_t open = 0;      ///< current connections
  std::uint64_t requests = 0;  ///< over HTTP and over WebSockets
  std::uint64_t failed = 0;    ///< requests answered with an error
  std::uint64_t skipped = 0;   ///< snapshots dropped for slow viewers
  api::DurationHistogram::Counts answer_times;
};

/// Robot name, description file.
using RobotModels = std::vector<std::pair<std::string, std::string>>;

struct WebServerOptions {
  /// A rejected connection gets status 503 and a page with the reason.
  protocols::ListenerOptions listener{
      .port = 8080, .limits = {.at_once = 32}, .drain_deadline = std::chrono::milliseconds(300)};
  std::size_t max_viewers = 24;                           ///< WebSockets; further ones get 503
  std::size_t max_waiting_bytes = std::size_t{16} << 20;  ///< of messages for all viewers
  double max_rate_hz = 60;                                ///< of snapshots
  bool control = true;                                    ///< false: no viewer may send commands
  std::string read_only;           ///< reason why no viewer may; empty = they may
  std::vector<std::string> hosts;  ///< accepted host names besides addresses and localhost
  std::string assets;              ///< directory of the page's files
  std::string documents;           ///< directory of the site under /docs; may be missing
  /// Names and description files of the present robots; called on the server's thread.
  std::function<RobotModels()> models = [] { return RobotModels(); };
  /// Shapes of a described cell; called once a scene. Thread: the web server's.
  std::function<VisualDescription(const api::CellDescription&)> visual;
  std::string version;
  modbus::ConveyorScaling scaling;  ///< of the registers shown
  std::chrono::milliseconds jog_timeout{400};
  protocols::WireTap* crcl_tap = nullptr;  ///< both must outlive the server; may be null
  protocols::WireTap* modbus_tap = nullptr;
  protocols::IncidentSource* incidents = nullptr;  ///< may be null; must outlive the server
  protocols::CameraPictures* cameras = nullptr;    ///< may be null; must outlive the server
  ProgramRunner* programs = nullptr;      ///< must outlive the server; null = none can be started
  api::History* history = nullptr;        ///< must outlive the server; null = no history
  api::MovePreviews* previews = nullptr;  ///< must outlive the server; null = no previews
  SceneDrafts* drafts = nullptr;          ///< must outlive the server; null = no scene is edited
  ScenarioDrafts* scenarios = nullptr;    ///< must outlive the server; null = none is edited
  std::function<std::vector<ListenerCount>()> listeners;  ///< called on the server's thread
  /// Text of /metrics in Prometheus' format; called on the server's thread. Null: 404.
  std::function<std::string()> metrics = {};
  /// Why the cell is not ready although it runs, for /readyz; empty = it is. Thread: the server's.
  std::function<std::string()> problem = [] { return std::string(); };
};

}  // namespace aprsim::web
