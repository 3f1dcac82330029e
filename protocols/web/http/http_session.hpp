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
#include "protocols/ports/incident_source.hpp"
#include "protocols/web/http/asset_table.hpp"
#include "protocols/web/http/web_counts.hpp"
#include "protocols/web/http/web_socket.hpp"

namespace aprsim::web {

/// Present content of a page.
struct LivePage {
  unsigned status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body;
};

/// Everything that HTTP sessions share.
struct HttpContext {
  std::shared_ptr<const AssetTable> assets;
  std::vector<std::string> hosts;   ///< names of this daemon besides numbers and localhost
  double max_requests_per_s = 200;  ///< of one connection; then 429 and the end
  /// A slot for another viewer, taken until it is destroyed; null when all are.
  std::function<std::shared_ptr<void>()> take_viewer_slot;
  /// Not empty: there is no room for this connection; whatever it asks for is answered with 503
  /// and this sentence.
  std::string full;
  /// Pages that are made when they are asked for, by path: status and text.
  std::map<std::string, std::function<LivePage()>, std::less<>> live;
  /// Source of the file behind /incident; null = there is none.
  protocols::IncidentSource* incidents = nullptr;
  /// Takes over an upgraded connection.
  std::function<void(std::shared_ptr<WebSocket>, std::string peer, protocols::Caller caller)>
      on_viewer;
  /// Permissions of callers; null where nothing needs a role.
  std::shared_ptr<protocols::Access> access;
  protocols::LimitedLog* refusals = nullptr;  ///< where they are told; may be null
  std::shared_ptr<protocols::Tls> tls;        ///< null = nothing is encrypted
  WebCounts* counts = nullptr;                ///< of what is asked for
};

/// One connection that speaks HTTP: GET and HEAD of the asset table, of live pages and of
/// /incident, and the upgrade of /ws to a WebSocket. Headers are limited to 8 KiB, bodies are
/// refused.
class HttpSession {
 public:
  virtual ~HttpSession() = default;
  /// Closes at once.
  virtual void close() = 0;
};

/// Starts a session; `on_end` is called once when the TCP connection is over, the WebSocket that it
/// may have become included. A viewer keeps its slot, an idle session may be evicted. The context
/// must outlive it.
std::shared_ptr<HttpSession> serve_http(boost::asio::ip::tcp::socket socket, std::string peer,
                                        const HttpContext& context,
                                        std::shared_ptr<protocols::ConnectionLimiter::Slot> slot,
                                        std::function<void()> on_end);

}  // namespace aprsim::web
