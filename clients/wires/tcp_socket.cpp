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

#include "clients/wires/endpoints.hpp"

namespace aprsim::client {

using std::chrono::steady_clock;
using namespace std::chrono_literals;

namespace {

constexpr std::chrono::milliseconds kLongestWait{1 << 30};

tl::unexpected<Failure> closed(const std::string& peer, const char* reason) {
  return failed(FailureKind::kConnection, fmt::format("{}: {}", peer, reason));
}

}  // namespace

TcpSocket::TcpSocket(TcpSocket&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), peer_(std::move(other.peer_)) {}

TcpSocket& TcpSocket::operator=(TcpSocket&& other) noexcept {
  std::swap(fd_, other.fd_);
  std::swap(peer_, other.peer_);
  return *this;
}

// With unread input, closing alone would reset the connection: a robot stops then, as its
// controller seems to be lost.
TcpSocket::~TcpSocket() {
  if (fd_ < 0) return;
  shutdown(fd_, SHUT_WR);
  close(fd_);
}

Outcome<void> TcpSocket::wait(short events, Time deadline, const Cancelled& cancelled) const {
  while (true) {
    if (is_cancelled(cancelled)) {
      return failed(FailureKind::kInterrupted, peer_ + ": interrupted");
    }
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - steady_clock::now());
    const auto span = std::clamp(left, 0ms, cancelled ? kCancellationPeriod : kLongestWait);
    pollfd waiting{fd_, events, 0};
    const int rc = poll(&waiting, 1, static_cast<int>(span.count()));
    if (rc > 0) return {};
    if (rc == 0 && left <= span) {
      return failed(FailureKind::kTimeout, peer_ + ": no answer in time");
    }
    if (rc < 0 && errno != EINTR) return closed(peer_, std::strerror(errno));
  }
}

Outcome<TcpSocket> TcpSocket::connect(const std::string& host, std::uint16_t port, Time deadline,
                                      const Cancelled& cancelled) {
  const std::string peer = host_and_port(host, port);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int rc = getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found)) {
    return closed(peer, gai_strerror(rc));
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owned(found, &freeaddrinfo);
  Outcome<TcpSocket> failure = closed(peer, "no address");
  for (const addrinfo* address = found; address != nullptr; address = address->ai_next) {
    TcpSocket out(socket(address->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0), peer);
    if (out.fd_ < 0) return closed(peer, std::strerror(errno));
    int error = ::connect(out.fd_, address->ai_addr, address->ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS) {
      if (const auto ready = out.wait(POLLOUT, deadline, cancelled); !ready) {
        // No host answers.
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
    failure = closed(peer, std::strerror(error));
  }
  return failure;
}

Outcome<void> TcpSocket::send(std::string_view bytes, Time deadline, const Cancelled& cancelled) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    } else if (errno == EAGAIN) {
      if (const auto ready = wait(POLLOUT, deadline, cancelled); !ready) return ready;
    } else if (errno != EINTR) {
      return closed(peer_, std::strerror(errno));
    }
  }
  return {};
}

Outcome<std::string> TcpSocket::receive(Time deadline, const Cancelled& cancelled) {
  std::array<char, 16384> buffer{};
  while (true) {
    const ssize_t received = recv(fd_, buffer.data(), buffer.size(), 0);
    if (received > 0) return std::string(buffer.data(), static_cast<std::size_t>(received));
    if (received == 0) {
      return closed(peer_, "the connection was closed");
    }
    if (errno == EAGAIN) {
      if (const auto ready = wait(POLLIN, deadline, cancelled); !ready)
        return tl::unexpected(ready.error());
    } else if (errno != EINTR) {
      return closed(peer_, std::strerror(errno));
    }
  }
}

}  // namespace aprsim::client
