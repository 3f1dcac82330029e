#pragma once

#include <utility>

#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/teardown.hpp>

#include "protocols/net/tls_stream.hpp"

namespace aprsim::web {

/// Connection of a browser, encrypted or not. Include this header in source files only. Thread: the
/// server's.
class WebStream : public protocols::TlsStream<boost::beast::tcp_stream> {
 public:
  using protocols::TlsStream<boost::beast::tcp_stream>::TlsStream;
};

// The closing handshake of the WebSocket came first, so TLS needs no shutdown of its own.

inline void teardown(boost::beast::role_type role, WebStream& stream,
                     boost::system::error_code& error) {
  using boost::beast::websocket::teardown;
  teardown(role, stream.next_layer().socket(), error);
}

template <typename Handler>
void async_teardown(boost::beast::role_type role, WebStream& stream, Handler&& handler) {
  using boost::beast::websocket::async_teardown;
  async_teardown(role, stream.next_layer().socket(), std::forward<Handler>(handler));
}

}  // namespace aprsim::web
