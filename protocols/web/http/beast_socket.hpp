#pragma once

#include <functional>
#include <memory>
#include <string>

#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>

#include "protocols/web/http/web_socket.hpp"
#include "protocols/web/http/web_stream.hpp"

namespace aprsim::web {

/// Answers an upgrade request; `on_open` gets the socket once the handshake is out. `on_end` is
/// called once when the connection is over, whether or not it opened.
void accept_web_socket(WebStream stream,
                       boost::beast::http::request<boost::beast::http::empty_body> request,
                       std::function<void(std::shared_ptr<WebSocket>)> on_open,
                       std::function<void()> on_end);

}  // namespace aprsim::web
