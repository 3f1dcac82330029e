#include "clients/wires/tcp_socket.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>

#include "clients/wires/interruption.hpp"

namespace aprsim::client {

using std::chrono::steady_clock;

namespace {

Failure connection_failure(const std::string& peer, const char* reason) {
  return {FailureKind::kConnection, fmt::format("{}: {}", peer, reason)};
}

}  // namespace

TcpSocket::TcpSocket(TcpSocket&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), peer_(std::move(other.peer_)) {}

TcpSocket& TcpSocket::operator=(TcpSocket&& other) noexcept {
  std::swap(fd_, other.fd_);
  std::swap(peer_, other.peer_);
  return *this;
}

TcpSocket::~TcpSocket() {
  if (fd_ >= 0) close(fd_);
}

Outcome<void> TcpSocket::wait(short events, Time deadline) const {
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - steady_clock::now());
    std::array<pollfd, 2> waiting{{{fd_, events, 0}, {interruption::wake_fd(), POLLIN, 0}}};
    const int rc = poll(waiting.data(), waiting.size(),
                        static_cast<int>(std::clamp<long>(left.count(), 0, 1 << 30)));
    if (rc > 0 && waiting[1].revents != 0) {
      return failed(FailureKind::kInterrupted, peer_ + ": interrupted");
    }
    if (rc > 0) return {};
    if (rc == 0) return failed(FailureKind::kTimeout, peer_ + ": no answer in time");
    if (errno != EINTR) return tl::unexpected(connection_failure(peer_, std::strerror(errno)));
  }
}

Outcome<TcpSocket> TcpSocket::connect(const std::string& host, std::uint16_t port, Time deadline) {
  const std::string peer = fmt::format("{}:{}", host, port);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int rc = getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found)) {
    return tl::unexpected(connection_failure(peer, gai_strerror(rc)));
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owned(found, &freeaddrinfo);
  Failure failure = connection_failure(peer, "no address");
  for (const addrinfo* address = found; address != nullptr; address = address->ai_next) {
    TcpSocket out(socket(address->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0), peer);
    if (out.fd_ < 0) return tl::unexpected(connection_failure(peer, std::strerror(errno)));
    int error = ::connect(out.fd_, address->ai_addr, address->ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS) {
      if (const auto ready = out.wait(POLLOUT, deadline); !ready) {
        // Nobody there, as far as one can tell.
        const bool late = ready.error().kind == FailureKind::kTimeout;
        return failed(late ? FailureKind::kConnection : ready.error().kind, ready.error().message);
      }
      socklen_t size = sizeof error;
      getsockopt(out.fd_, SOL_SOCKET, SO_ERROR, &error, &size);
    }
    if (error == 0) {
      const int yes = 1;
      setsockopt(out.fd_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
      return out;
    }
    failure = connection_failure(peer, std::strerror(error));
  }
  return tl::unexpected(failure);
}

Outcome<void> TcpSocket::send(std::string_view bytes, Time deadline) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    } else if (errno == EAGAIN) {
      if (const auto ready = wait(POLLOUT, deadline); !ready) return ready;
    } else if (errno != EINTR) {
      return tl::unexpected(connection_failure(peer_, std::strerror(errno)));
    }
  }
  return {};
}

Outcome<std::string> TcpSocket::receive(Time deadline) {
  std::array<char, 16384> buffer{};
  while (true) {
    const ssize_t received = recv(fd_, buffer.data(), buffer.size(), 0);
    if (received > 0) return std::string(buffer.data(), static_cast<std::size_t>(received));
    if (received == 0) {
      return tl::unexpected(connection_failure(peer_, "the connection was closed"));
    }
    if (errno == EAGAIN) {
      if (const auto ready = wait(POLLIN, deadline); !ready) return tl::unexpected(ready.error());
    } else if (errno != EINTR) {
      return tl::unexpected(connection_failure(peer_, std::strerror(errno)));
    }
  }
}

}  // namespace aprsim::client
