#include "tests/unit/modbus/raw_client.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdexcept>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>
#include <utility>

namespace aprsim::protocols::testing {

using Clock = std::chrono::steady_clock;

RawClient::RawClient(std::uint16_t port, int receive_buffer)
    : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  if (receive_buffer > 0) {
    ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
  }
  const int on = 1;
  ::setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    throw std::runtime_error("cannot connect");
  }
}

RawClient::~RawClient() {
  if (fd_ >= 0) ::close(fd_);
}
RawClient::RawClient(RawClient&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

bool RawClient::send(const Bytes& bytes) {
  std::size_t sent = 0;
  while (sent < bytes.size()) {
    const ssize_t n = ::send(fd_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (n <= 0) return false;
    sent += static_cast<std::size_t>(n);
  }
  return true;
}

std::size_t RawClient::send_some(const Bytes& bytes) {
  const ssize_t n = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  return n > 0 ? static_cast<std::size_t>(n) : 0;
}

bool RawClient::readable(Clock::time_point deadline) const {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
  pollfd waiting{fd_, POLLIN, 0};
  return ::poll(&waiting, 1, static_cast<int>(std::max<std::int64_t>(left.count(), 0))) == 1;
}

std::optional<Bytes> RawClient::exactly(std::size_t size, Clock::time_point deadline) {
  Bytes bytes(size);
  std::size_t got = 0;
  while (got < size) {
    if (!readable(deadline)) return std::nullopt;
    const ssize_t n = ::recv(fd_, bytes.data() + got, size - got, 0);
    if (n <= 0) return std::nullopt;
    got += static_cast<std::size_t>(n);
  }
  return bytes;
}

std::optional<Bytes> RawClient::receive(std::chrono::milliseconds within) {
  const auto deadline = Clock::now() + within;
  auto frame = exactly(6, deadline);
  if (!frame) return std::nullopt;
  const auto rest = exactly(static_cast<std::size_t>((*frame)[4] * 256 + (*frame)[5]), deadline);
  if (!rest) return std::nullopt;
  frame->insert(frame->end(), rest->begin(), rest->end());
  return frame;
}

std::optional<Bytes> RawClient::ask(const Bytes& frame, std::chrono::milliseconds within) {
  if (!send(frame)) return std::nullopt;
  return receive(within);
}

bool RawClient::ended(std::chrono::milliseconds within) {
  const auto deadline = Clock::now() + within;
  std::array<std::uint8_t, 4096> scratch{};
  while (readable(deadline)) {
    if (::recv(fd_, scratch.data(), scratch.size(), 0) <= 0) return true;
  }
  return false;
}

void RawClient::half_close() { ::shutdown(fd_, SHUT_WR); }

void RawClient::reset() {
  const linger abort{1, 0};
  ::setsockopt(fd_, SOL_SOCKET, SO_LINGER, &abort, sizeof abort);
  ::close(std::exchange(fd_, -1));
}

bool eventually(const std::function<bool()>& condition, std::chrono::milliseconds within) {
  const auto deadline = Clock::now() + within;
  while (!condition()) {
    if (Clock::now() > deadline) return false;
    std::this_thread::yield();
  }
  return true;
}

}  // namespace aprsim::protocols::testing
