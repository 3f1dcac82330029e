#pragma once

#include <cerrno>
#include <optional>
#include <poll.h>
#include <sys/socket.h>

#include <boost/asio/error.hpp>

namespace aprsim::protocols {

/// How a peer has ended its side of a connection.
enum class PeerEnd {
  kClosed,  ///< it sends no more (FIN); it may still read
  kLost     ///< it was reset or has timed out: nothing reaches it
};

/// Classifies the error of a read or a write.
[[nodiscard]] inline PeerEnd peer_end(const boost::system::error_code& error) {
  // Linux reports EPIPE for a reset that follows a FIN: the peer had closed.
  const bool closed = error == boost::asio::error::eof || error == boost::asio::error::broken_pipe;
  return closed ? PeerEnd::kClosed : PeerEnd::kLost;
}

/// A peer's end that the system has received, although bytes before it are unread.
struct NoticedEnd {
  PeerEnd end = PeerEnd::kClosed;
  boost::system::error_code error;  ///< eof while the peer may still read
};

/// Checks a TCP socket without reading. Empty while the peer is connected. Never blocks.
[[nodiscard]] inline std::optional<NoticedEnd> notice_peer_end(int socket) {
  pollfd entry{socket, POLLRDHUP, 0};
  if (::poll(&entry, 1, 0) <= 0) return std::nullopt;
  const int seen = entry.revents;
  if ((seen & (POLLERR | POLLHUP | POLLNVAL)) == 0) {
    return NoticedEnd{PeerEnd::kClosed, boost::asio::error::eof};
  }
  int code = 0;
  socklen_t size = sizeof code;
  (void)::getsockopt(socket, SOL_SOCKET, SO_ERROR, &code, &size);
  const boost::system::error_code error(code != 0 ? code : EPIPE, boost::system::system_category());
  return NoticedEnd{peer_end(error), error};
}

}  // namespace aprsim::protocols
