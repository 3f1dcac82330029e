#include "protocols/net/tcp_listener.hpp"

#include <chrono>
#include <exception>
#include <memory>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <span>
#include <sys/socket.h>
#include <utility>
#include <vector>

#include <boost/asio/error.hpp>
#include <boost/asio/ip/address.hpp>
#include <spdlog/spdlog.h>

namespace aprsim::protocols {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

constexpr auto kRetryDelay = std::chrono::milliseconds(100);
constexpr auto kLogInterval = std::chrono::seconds(1);
constexpr int kAcceptsPerTurn = 32;
constexpr int kPortAttempts = 100;

/// The addresses to bind; none for a text that is no address.
std::vector<asio::ip::address> addresses_of(const std::string& text) {
  if (text == "localhost") {
    return {asio::ip::address_v4::loopback(), asio::ip::address_v6::loopback()};
  }
  error_code error;
  const asio::ip::address address = asio::ip::make_address(text, error);
  return error ? std::vector<asio::ip::address>() : std::vector{address};
}

/// Whether the machine does not have the address, or not its protocol.
bool is_missing(const error_code& error) {
  return error == asio::error::address_family_not_supported ||
         error == boost::system::errc::address_not_available;
}

std::string text(const tcp::endpoint& peer) {
  const std::string address = peer.address().to_string();
  const std::string host = peer.address().is_v6() ? "[" + address + "]" : address;
  return host + ":" + std::to_string(peer.port());
}

void set_option(int fd, int level, int option, int value) {
  // An option that the system does not know stays at its default.
  (void)::setsockopt(fd, level, option, &value, sizeof value);
}

// A peer that vanishes without FIN or RST is detected after 11 s (5 s idle, then 3 probes 2 s
// apart), or after 10 s if data are unacknowledged.
void prepare(tcp::socket& socket) {
  const int fd = socket.native_handle();
  set_option(fd, IPPROTO_TCP, TCP_NODELAY, 1);
  set_option(fd, SOL_SOCKET, SO_KEEPALIVE, 1);
  set_option(fd, IPPROTO_TCP, TCP_KEEPIDLE, 5);
  set_option(fd, IPPROTO_TCP, TCP_KEEPINTVL, 2);
  set_option(fd, IPPROTO_TCP, TCP_KEEPCNT, 3);
  set_option(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, 10'000);
}

}  // namespace

TcpListener::TcpListener(asio::io_context& io, std::string name, ListenerOptions options,
                         OnAccept on_accept, OnRefused on_refused)
    : name_(std::move(name)),
      options_(std::move(options)),
      on_accept_(std::move(on_accept)),
      on_refused_(std::move(on_refused)),
      acceptors_{tcp::acceptor(io), tcp::acceptor(io)},
      retry_(io),
      limiter_(ConnectionLimiter::create(options_.limits)) {}

Result<std::uint16_t> TcpListener::listen() {
  auto allow = AllowList::from(options_.allow, name_ + ".allow");
  if (!allow) return tl::unexpected(allow.error());
  allow_ = std::move(*allow);
  const auto addresses = addresses_of(options_.address);
  if (addresses.empty()) {
    return fail(ErrorCode::kInvalidArgument, name_ + ".address",
                "cannot listen on " + options_.address +
                    ": neither a numeric IPv4 or IPv6 address nor localhost");
  }
  // A port that the system picks for one address may be taken at the other.
  const int attempts = options_.port == 0 && addresses.size() > 1 ? kPortAttempts : 1;
  Result<std::uint16_t> port;
  for (int i = 0; i < attempts; ++i) {
    port = bind_all(addresses);
    if (port) break;
    close();
  }
  if (!port) return port;
  options_.port = *port;  // the same again after a pause
  for (auto& acceptor : acceptors_) {
    if (acceptor.is_open()) accept(acceptor);
  }
  return port;
}

Result<std::uint16_t> TcpListener::bind_all(std::span<const asio::ip::address> addresses) {
  std::uint16_t port = options_.port;
  for (std::size_t i = 0; i < addresses.size(); ++i) {
    tcp::acceptor& acceptor = acceptors_[i];
    const tcp::endpoint endpoint(addresses[i], port);
    error_code error;
    acceptor.open(endpoint.protocol(), error);
    if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (!error) acceptor.non_blocking(true, error);
    const tcp::endpoint bound = error ? endpoint : acceptor.local_endpoint(error);
    if (error && i > 0 && is_missing(error)) {
      // A machine without IPv6 has one loopback only.
      error_code ignored;
      acceptor.close(ignored);
      continue;
    }
    if (error) {
      return fail(ErrorCode::kUnavailable, name_,
                  "cannot listen on " + addresses[i].to_string() + " port " + std::to_string(port) +
                      ": " + error.message());
    }
    port = bound.port();
  }
  return port;
}

void TcpListener::resume() {
  if (acceptors_.front().is_open()) return;
  const Result<std::uint16_t> port = listen();
  if (port) return;
  spdlog::error("{}: {}; retrying", name_, port.error().message);
  close();
  retry_.expires_after(kRetryDelay);
  retry_.async_wait([this](const error_code& cancelled) {
    if (!cancelled) resume();
  });
}

void TcpListener::close() {
  error_code ignored;
  for (auto& acceptor : acceptors_) acceptor.close(ignored);
  retry_.cancel(ignored);
}

void TcpListener::accept(tcp::acceptor& acceptor) {
  acceptor.async_wait(tcp::acceptor::wait_read, [this, &acceptor](const error_code& aborted) {
    if (!aborted && acceptor.is_open()) accept_waiting(acceptor);
  });
}

void TcpListener::accept_waiting(tcp::acceptor& acceptor) {
  for (int i = 0; i < kAcceptsPerTurn; ++i) {
    tcp::socket socket(acceptor.get_executor());
    error_code error;
    acceptor.accept(socket, error);
    if (error == asio::error::would_block) break;
    if (error == asio::error::connection_aborted) continue;
    if (error) return retry_later(acceptor, error.message());
    try {
      admit(std::move(socket));
    } catch (const std::exception& problem) {
      return retry_later(acceptor, problem.what());
    }
  }
  accept(acceptor);
}

// A socket that gets no slot is closed.
void TcpListener::admit(tcp::socket socket) {
  error_code gone;
  const tcp::endpoint endpoint = socket.remote_endpoint(gone);
  if (gone) return;
  std::string peer = text(endpoint);
  if (!allow_.allows(endpoint.address())) {
    refuse(peer, "its address is not on the allow list");
    return;
  }
  Result<Slot> slot = limiter_->take(endpoint.address().to_string());
  if (!slot) {
    refuse(peer, slot.error().message);
    if (on_refused_) {
      prepare(socket);
      on_refused_(std::move(socket), peer);
    }
    return;
  }
  ++accepted_;
  prepare(socket);
  on_accept_(std::move(socket), std::move(peer), std::move(*slot));
}

// A flood of refusals makes one log line a second.
void TcpListener::refuse(const std::string& peer, const std::string& why) {
  ++refused_;
  ++refused_unlogged_;
  if (options_.refusals != nullptr) {
    options_.refusals->refused(name_, "connection of " + peer + ": " + why);
  }
  const auto now = std::chrono::steady_clock::now();
  if (now - last_refusal_log_ < kLogInterval) return;
  spdlog::warn("{}: refused {}: {} ({} refused since the last line)", name_, peer, why,
               refused_unlogged_);
  last_refusal_log_ = now;
  refused_unlogged_ = 0;
}

// Descriptors or memory are exhausted. The connection stays in the queue, so an immediate retry
// would spin.
void TcpListener::retry_later(tcp::acceptor& acceptor, const std::string& why) {
  const auto now = std::chrono::steady_clock::now();
  if (now - last_failure_log_ >= kLogInterval) {
    spdlog::error("{}: cannot accept: {}; retrying", name_, why);
    last_failure_log_ = now;
  }
  // Both acceptors may wait at once.
  const auto retry = std::make_shared<asio::steady_timer>(acceptor.get_executor(), kRetryDelay);
  retry->async_wait([this, &acceptor, retry](const error_code& cancelled) {
    if (!cancelled && acceptor.is_open()) accept(acceptor);
  });
}

}  // namespace aprsim::protocols
