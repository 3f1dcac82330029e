#pragma once

#include <utility>

#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/teardown.hpp>

#include "protocols/net/tls_stream.hpp"

namespace aprsim::web {

/// A browser's connection, encrypted or not. For use inside the listener; its header stays out of
/// other headers. Thread: the server's.
class WebStream : public protocols::TlsStream<boost::beast::tcp_stream> {
 public:
  using protocols::TlsStream<boost::beast::tcp_stream>::TlsStream;
};

// A WebSocket has said goodbye in its own words before it is torn down: no more of TLS is needed.

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
