#include "protocols/telemetry/connection_acceptor.hpp"

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <exception>
#include <linux/tcp.h>
#include <memory>
#include <netdb.h>
#include <netinet/in.h>
#include <optional>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>

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
  return fmt::format(address.ss_family == AF_INET6 ? "[{}]:{}" : "{}:{}", host.data(),
                     service.data());
}

// Who has sent less than HTTP/2's preface has asked for nothing.
constexpr std::uint64_t kPrefaceBytes = 24;

/// How long ago the peer has sent something; nothing when it has not sent enough to be a client.
std::optional<std::chrono::milliseconds> silence_of(int fd) {
  tcp_info info{};
  socklen_t size = sizeof info;
  if (getsockopt(fd, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return std::nullopt;
  if (info.tcpi_bytes_received < kPrefaceBytes) return std::nullopt;
  return std::chrono::milliseconds(info.tcpi_last_data_recv);
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
    const bool waited = poll(waits.data(), waits.size(), -1) > 0;
    if (waited && waits[0].revents != 0) return;
    if (waited && (waits[1].revents == 0 || accept_one())) continue;
    // Out of descriptors or memory: the connection stays in the backlog until some are free.
    if (poll(waits.data(), 1, kPauseWhenExhaustedMs) > 0) return;
  }
}

/// False when the next one had better wait a while.
bool ConnectionAcceptor::accept_one() {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  const int fd = accept4(listen_fd_, reinterpret_cast<sockaddr*>(&address), &size,
                         SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (fd < 0) {
    const bool exhausted =
        errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM;
    if (exhausted) log_.warn(fmt::format("cannot accept: {}; trying again", std::strerror(errno)));
    return !exhausted;
  }
  try {
    admit(fd, peer_of(address, size));
  } catch (const std::exception& problem) {
    log_.warn(fmt::format("cannot accept: {}; trying again", problem.what()));
    return false;
  }
  return true;
}

void ConnectionAcceptor::admit(int fd, const std::string& peer) {
  struct Closing {
    int fd;
    ~Closing() {
      if (fd >= 0) close(fd);
    }
  } owned{fd};
  {
    const std::lock_guard lock(mutex_);
    forget_ended();
    look_at_use();
    auto place = places_->take(protocols::host_of(peer));
    if (!place) {
      ++refused_;
      log_.warn(fmt::format("refused {}: {}", peer, place.error().message));
      return;
    }
    const int yes = 1;
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    const auto cookie = cookie_of(fd);
    if (!cookie) return;
    place->on_needed([fd, cookie, peer, this] {
      if (cookie_of(fd) != cookie) return;
      log_.warn(fmt::format("closing {}: its place is needed", peer));
      // gRPC, whose socket it is, sees its end.
      shutdown(fd, SHUT_RDWR);
    });
    connections_.push_back({fd, *cookie, std::move(*place)});
  }
  handler_(std::exchange(owned.fd, -1));
}

std::size_t ConnectionAcceptor::open() {
  const std::lock_guard lock(mutex_);
  forget_ended();
  return connections_.size();
}

// gRPC does not tell when it closes a socket it was given: ask the kernel which are still there.
void ConnectionAcceptor::forget_ended() {
  std::erase_if(connections_, [](const Connection& connection) {
    return cookie_of(connection.fd) != connection.cookie;
  });
}

// Nor does it tell which are in use.
void ConnectionAcceptor::look_at_use() {
  const auto now = protocols::ConnectionPlaces::Clock::now();
  for (Connection& connection : connections_) {
    if (const auto silence = silence_of(connection.fd)) connection.place.used(now - *silence);
  }
}

}  // namespace aprsim::telemetry
