#include "tests/support/tcp_socket.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <cstring>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdexcept>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

namespace aprsim::test {
namespace {

bool wait(int fd, short events, TcpSocket::Clock::time_point deadline) {
  const auto left =
      std::chrono::ceil<std::chrono::milliseconds>(deadline - TcpSocket::Clock::now());
  pollfd waiting{fd, events, 0};
  return ::poll(&waiting, 1, static_cast<int>(std::max<std::int64_t>(left.count(), 0))) == 1;
}

}  // namespace

TcpSocket::TcpSocket(std::uint16_t port, int receive_buffer, const std::string& from)
    : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  if (receive_buffer > 0) {
    ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
  }
  const int on = 1;
  ::setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  if (!from.empty()) {
    ::inet_pton(AF_INET, from.c_str(), &address.sin_addr);
    if (::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      const std::string reason = std::strerror(errno);
      ::close(fd_);
      throw std::runtime_error("cannot bind to " + from + ": " + reason);
    }
  }
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    const std::string reason = std::strerror(errno);
    ::close(fd_);
    throw std::runtime_error("cannot connect to port " + std::to_string(port) + ": " + reason);
  }
}

TcpSocket::~TcpSocket() {
  if (fd_ >= 0) ::close(fd_);
}

TcpSocket::TcpSocket(TcpSocket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

bool TcpSocket::send(std::string_view bytes, std::chrono::milliseconds within) {
  const auto deadline = Clock::now() + within;
  while (true) {
    const auto sent = send_some(bytes);
    if (!sent) return false;
    bytes.remove_prefix(*sent);
    if (bytes.empty()) return true;
    if (!wait(fd_, POLLOUT, deadline)) return false;
  }
}

std::optional<std::size_t> TcpSocket::send_some(std::string_view bytes) {
  const ssize_t sent = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  if (sent >= 0) return static_cast<std::size_t>(sent);
  if (errno == EAGAIN) return 0;
  return std::nullopt;
}

bool TcpSocket::readable(Clock::time_point deadline) const { return wait(fd_, POLLIN, deadline); }

std::string TcpSocket::receive(Clock::time_point deadline) {
  std::array<char, 16384> buffer{};
  while (true) {
    if (const auto size = receive_some(buffer)) return {buffer.data(), *size};
    if (!readable(deadline)) throw std::runtime_error("nothing came in time");
  }
}

std::optional<std::size_t> TcpSocket::receive_some(std::span<char> buffer) {
  const ssize_t size = ::recv(fd_, buffer.data(), buffer.size(), MSG_DONTWAIT);
  if (size >= 0) return static_cast<std::size_t>(size);
  if (errno == EAGAIN) return std::nullopt;
  return 0;
}

bool TcpSocket::ended(std::chrono::milliseconds within) {
  const auto deadline = Clock::now() + within;
  std::array<char, 16384> scratch{};
  while (readable(deadline)) {
    if (receive_some(scratch) == 0U) return true;
  }
  return false;
}

void TcpSocket::finish_sending() { ::shutdown(fd_, SHUT_WR); }

void TcpSocket::reset() {
  const linger abort{1, 0};
  ::setsockopt(fd_, SOL_SOCKET, SO_LINGER, &abort, sizeof abort);
  ::close(std::exchange(fd_, -1));
}

}  // namespace aprsim::test
