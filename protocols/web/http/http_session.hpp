#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <boost/asio/ip/tcp.hpp>

#include "protocols/access/access.hpp"
#include "protocols/net/connection_limiter.hpp"
#include "protocols/net/limited_log.hpp"
#include "protocols/net/tls.hpp"
#include "protocols/ports/camera_pictures.hpp"
#include "protocols/ports/incident_source.hpp"
#include "protocols/web/http/asset_table.hpp"
#include "protocols/web/http/web_counts.hpp"
#include "protocols/web/http/web_socket.hpp"

namespace aprsim::web {

/// Content of a page, generated on request.
struct LivePage {
  unsigned status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body;
};

/// Everything that HTTP sessions share.
struct HttpContext {
  std::shared_ptr<const AssetTable> assets;
  /// Assets of the present robots, which change with the scene.
  std::function<std::shared_ptr<const AssetTable>()> models;
  std::vector<std::string> hosts;   ///< names of this daemon besides numbers and localhost
  double max_requests_per_s = 200;  ///< per connection; above it, 429 and disconnection
  /// Reserves a slot for a viewer until the result is destroyed; null where none is free.
  std::function<std::shared_ptr<void>()> take_viewer_slot;
  /// Not empty: the connection limit is reached, and every request is answered with 503 and this
  /// sentence.
  std::string full;
  /// Pages that are generated on request, by path.
  std::map<std::string, std::function<LivePage()>, std::less<>> live;
  /// Source of the file behind /incident; may be null.
  protocols::IncidentSource* incidents = nullptr;
  /// Source of the pictures behind /camera; may be null.
  protocols::CameraPictures* cameras = nullptr;
  /// Takes over an upgraded connection.
  std::function<void(std::shared_ptr<WebSocket>, std::string peer, protocols::Caller caller)>
      on_viewer;
  /// Permissions of callers; null = no role is needed.
  std::shared_ptr<protocols::Access> access;
  protocols::LimitedLog* refusals = nullptr;  ///< log of refused requests; may be null
  std::shared_ptr<protocols::Tls> tls;        ///< null = no encryption
  WebCounts* counts = nullptr;                ///< statistics of requests
};

/// One HTTP connection: GET and HEAD of assets, live pages, /incident and /camera, and the upgrade
/// of /ws to a WebSocket. Headers are limited to 8 KiB; request bodies are refused.
class HttpSession {
 public:
  virtual ~HttpSession() = default;
  /// Closes the connection immediately.
  virtual void close() = 0;
};

/// Starts a session. `on_end` is called once, after the TCP connection has ended; for a session
/// that became a WebSocket, after that has ended. Viewers keep their slot; idle sessions may be
/// evicted. The context must outlive the session.
std::shared_ptr<HttpSession> serve_http(boost::asio::ip::tcp::socket socket, std::string peer,
                                        const HttpContext& context,
                                        std::shared_ptr<protocols::ConnectionLimiter::Slot> slot,
                                        std::function<void()> on_end);

}  // namespace aprsim::web
