#include "protocols/telemetry/connection_acceptor.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <optional>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace aprsim::telemetry {
namespace {

constexpr int kBacklog = 64;
constexpr int kPauseWhenExhaustedMs = 100;

std::optional<std::uint64_t> cookie_of(int fd) {
  std::uint64_t cookie = 0;
  socklen_t size = sizeof cookie;
  if (getsockopt(fd, SOL_SOCKET, SO_COOKIE, &cookie, &size) != 0) return std::nullopt;
  return cookie;
}

std::string peer_of(const sockaddr_storage& address, socklen_t size) {
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> service{};
  if (getnameinfo(reinterpret_cast<const sockaddr*>(&address), size, host.data(), host.size(),
                  service.data(), service.size(), NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
    return "unknown peer";
  }
  return fmt::format("{}:{}", host.data(), service.data());
}

std::uint16_t port_of(int fd) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0) return 0;
  return ntohs(address.ss_family == AF_INET6
                   ? reinterpret_cast<const sockaddr_in6&>(address).sin6_port
                   : reinterpret_cast<const sockaddr_in&>(address).sin_port);
}

}  // namespace

ConnectionAcceptor::~ConnectionAcceptor() { stop(); }

Result<std::uint16_t> ConnectionAcceptor::listen(const std::string& address, std::uint16_t port) {
  addrinfo hints{};
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int rc = getaddrinfo(address.c_str(), std::to_string(port).c_str(), &hints, &found)) {
    return fail(ErrorCode::kInvalidArgument, "grpc.address",
                fmt::format("'{}' is no numeric address: {}", address, gai_strerror(rc)));
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(found, &freeaddrinfo);
  listen_fd_ = socket(found->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int yes = 1;
  const bool ok = listen_fd_ >= 0 &&
                  setsockopt(listen_fd_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) == 0 &&
                  bind(listen_fd_, found->ai_addr, found->ai_addrlen) == 0 &&
                  ::listen(listen_fd_, kBacklog) == 0;
  if (!ok) {
    return fail(ErrorCode::kUnavailable, "grpc.port",
                fmt::format("cannot listen on {}:{}: {}", address, port, std::strerror(errno)));
  }
  stop_fd_ = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (stop_fd_ < 0) {
    return fail(ErrorCode::kUnavailable, "grpc.port",
                fmt::format("cannot make an eventfd: {}", std::strerror(errno)));
  }
  return port_of(listen_fd_);
}

void ConnectionAcceptor::run(Handler handler) {
  handler_ = std::move(handler);
  thread_ = std::thread([this] { loop(); });
}

void ConnectionAcceptor::stop() {
  if (thread_.joinable()) {
    const std::uint64_t one = 1;
    // An eventfd takes a first write of one without fail.
    [[maybe_unused]] const auto written = write(stop_fd_, &one, sizeof one);
    thread_.join();
  }
  if (listen_fd_ >= 0) close(std::exchange(listen_fd_, -1));
  if (stop_fd_ >= 0) close(std::exchange(stop_fd_, -1));
}

void ConnectionAcceptor::loop() {
  std::array<pollfd, 2> waits{{{stop_fd_, POLLIN, 0}, {listen_fd_, POLLIN, 0}}};
  while (true) {
    if (poll(waits.data(), waits.size(), -1) < 0 && errno != EINTR) return;
    if (waits[0].revents != 0) return;
    if (waits[1].revents == 0 || accept_one()) continue;
    // Out of descriptors or memory: the connection stays in the backlog until some are free.
    if (poll(waits.data(), 1, kPauseWhenExhaustedMs) > 0) return;
  }
}

bool ConnectionAcceptor::accept_one() {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  const int fd = accept4(listen_fd_, reinterpret_cast<sockaddr*>(&address), &size,
                         SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (fd < 0) {
    const bool exhausted =
        errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM;
    if (exhausted) spdlog::warn("grpc: cannot accept a connection: {}", std::strerror(errno));
    return !exhausted;
  }
  if (open() >= static_cast<std::size_t>(max_connections_)) {
    ++refused_;
    spdlog::warn("grpc: {} refused, {} connections are open already", peer_of(address, size),
                 max_connections_);
    close(fd);
    return true;
  }
  const int yes = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  if (const auto cookie = cookie_of(fd)) {
    const std::lock_guard lock(mutex_);
    connections_.push_back({fd, *cookie});
  }
  spdlog::debug("grpc: {} connected", peer_of(address, size));
  handler_(fd);
  return true;
}

std::size_t ConnectionAcceptor::open() {
  const std::lock_guard lock(mutex_);
  // gRPC does not tell when it closes a socket it was given: ask the kernel which are still there.
  std::erase_if(connections_, [](const Connection& connection) {
    return cookie_of(connection.fd) != connection.cookie;
  });
  return connections_.size();
}

}  // namespace aprsim::telemetry
