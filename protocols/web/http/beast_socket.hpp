#pragma once

#include <functional>
#include <memory>
#include <string>

#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>

#include "protocols/web/http/web_socket.hpp"
#include "protocols/web/http/web_stream.hpp"

namespace aprsim::web {

/// Accepts an upgrade request. `on_open` receives the socket after the handshake. `on_end` is
/// called once when the connection has ended, even if it never opened.
void accept_web_socket(WebStream stream,
                       boost::beast::http::request<boost::beast::http::empty_body> request,
                       std::function<void(std::shared_ptr<WebSocket>)> on_open,
                       std::function<void()> on_end);

}  // namespace aprsim::web
