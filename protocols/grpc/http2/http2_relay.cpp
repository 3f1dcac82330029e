#include "protocols/grpc/http2/http2_relay.hpp"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/write.hpp>
#include <fmt/format.h>

namespace aprsim::grpc_server {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

/// Kernel buffers between gRPC and the relay: data that waits there is stale for a slow reader.
constexpr int kPairBufferBytes = 64 * 1024;
constexpr int kSendBufferBytes = 256 * 1024;
/// After a refusal the client may read the reason, for this time and while it sends no more than
/// these bytes: closing a socket with unread data discards the sent data.
constexpr std::chrono::milliseconds kLinger{500};
constexpr std::size_t kMaxRestBytes = std::size_t{1} << 20;

/// A client that has sent less than HTTP/2's preface has made no request.
constexpr std::size_t kPrefaceBytes = 24;

/// Period at which a waiting connection queries its turn.
constexpr std::chrono::milliseconds kTurnPeriod{20};

/// GOAWAY on behalf of gRPC: any stream may have been processed, ENHANCE_YOUR_CALM.
std::string go_away(const std::string& why) {
  const std::size_t length = 8 + why.size();
  std::string frame{static_cast<char>(length >> 16U),
                    static_cast<char>(length >> 8U),
                    static_cast<char>(length),
                    7,
                    0,
                    0,
                    0,
                    0,
                    0,
                    0x7F,
                    '\xFF',
                    '\xFF',
                    '\xFF',
                    0,
                    0,
                    0,
                    0x0B};
  return frame + why;
}

/// gRPC identifies peers by the names of their sockets: name the socket after the client.
void name_end(int fd, const std::string& name) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::size_t length = std::min(name.size(), sizeof address.sun_path - 1);
  // The name is in the abstract namespace, where nothing listens.
  std::memcpy(address.sun_path + 1, name.data(), length);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + length);
  (void)bind(fd, reinterpret_cast<const sockaddr*>(&address), size);
}

}  // namespace

Http2Relay::Http2Relay(Socket client, std::string peer, protocols::ConnectionLimiter::Slot slot,
                       protocols::ConnectionTrace trace, const RelayRules& rules,
                       protocols::LimitedLog& log, Backoff& probation)
    : client_(std::move(client), rules.tls ? rules.tls->context() : nullptr),
      server_(client_.get_executor()),
      peer_(std::move(peer)),
      slot_(std::move(slot)),
      trace_(std::move(trace)),
      rules_(rules),
      log_(log),
      backoff_(probation),
      guard_(rules.limits),
      hear_timer_(client_.get_executor()),
      stall_timer_(client_.get_executor()) {}

void Http2Relay::start() {
  error_code gone;
  address_ = socket().remote_endpoint(gone).address();
  if (!gone) socket().non_blocking(true, gone);
  if (gone) return close();
  wait_for_turn();
}

void Http2Relay::wait_for_turn() {
  const auto now = Http2Guard::Clock::now();
  // Short-lived clients must not delay waiting ones.
  if (client_has_gone()) return close();
  if (backoff_.may_begin(address_, this, now)) {
    waiting_ = false;
    if (backoff_.on(address_, now)) guard_ = Http2Guard(rules_.backoff_limits);
    return client_.is_secure() ? shake_hands() : connect();
  }
  waiting_ = true;
  hear_timer_.expires_after(kTurnPeriod);
  hear_timer_.async_wait([self = shared_from_this()](const error_code& cancelled) {
    if (!cancelled && !self->closed_) self->wait_for_turn();
  });
}

/// Also after the bytes that it has sent.
bool Http2Relay::client_has_gone() {
  tcp_info info{};
  socklen_t size = sizeof info;
  return getsockopt(socket().native_handle(), IPPROTO_TCP, TCP_INFO, &info, &size) != 0 ||
         info.tcpi_state != TCP_ESTABLISHED;
}

void Http2Relay::shake_hands() {
  stall_timer_.expires_after(rules_.handshake_timeout);
  stall_timer_.async_wait([self = shared_from_this()](const error_code& cancelled) {
    if (cancelled || self->closed_) return;
    self->log_.warn("closing " + self->peer_ + ": no TLS handshake in time");
    self->close();
  });
  client_.async_handshake([self = shared_from_this()](const error_code& error) {
    if (self->closed_) return;
    error_code ignored;
    self->stall_timer_.cancel(ignored);
    if (!error) return self->connect();
    self->log_.warn("closing " + self->peer_ + ": " +
                    self->rules_.tls->failure(self->client_.native_handle(), error.message()));
    self->close();
  });
}

void Http2Relay::connect() {
  const int grpc_end = make_pair();
  if (grpc_end < 0) {
    log_.warn(fmt::format("closing {}: no socket pair: {}", peer_, std::strerror(errno)));
    return close();
  }
  // Bound the kernel buffers of a client that reads nothing, so that it is detected soon.
  error_code ignored;
  socket().set_option(asio::socket_base::send_buffer_size(kSendBufferBytes), ignored);
  if (rules_.clients != nullptr) {
    rules_.clients->add(
        name_, {peer_, client_.is_secure() ? protocols::Tls::client_of(client_.native_handle())
                                           : nullptr});
  }
  rules_.hand_over(grpc_end);
  read_client();
  read_server();
}

int Http2Relay::make_pair() {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    return -1;
  }
  for (const int end : ends) {
    (void)setsockopt(end, SOL_SOCKET, SO_SNDBUF, &kPairBufferBytes, sizeof kPairBufferBytes);
  }
  // The descriptor's number tells apart connections of one client port to two listeners; the last
  // one is for call_peer().
  name_ = fmt::format("{}/{}.{}.{}", peer_, getpid(), ends[0], trace_.number());
  name_end(ends[0], name_);
  error_code error;
  server_.assign(asio::local::stream_protocol(), ends[0], error);
  if (!error) return ends[1];
  for (const int end : ends) ::close(end);
  return -1;
}

void Http2Relay::drain() {
  if (waiting_ || refused_) close();
}

void Http2Relay::close() {
  if (closed_) return;
  closed_ = true;
  if (waiting_) backoff_.leave(address_, this);
  error_code ignored;
  hear_timer_.cancel(ignored);
  stall_timer_.cancel(ignored);
  socket().shutdown(Socket::shutdown_both, ignored);
  socket().close(ignored);
  server_.close(ignored);
  trace_.closed(end_);
  if (rules_.clients != nullptr && !name_.empty()) rules_.clients->remove(name_);
  rules_.on_end(*this);
}

void Http2Relay::evict() {
  if (closed_) return;
  log_.warn("closing " + peer_ + ": its place is needed");
  end_ = "its place is needed";
  close();
}

/// Continues reading when the guard permits it.
void Http2Relay::hear() {
  if (closed_ || refused_) return;
  deaf_ = guard_.awaits_answers();
  if (deaf_) return;
  const auto pause = guard_.pause(Http2Guard::Clock::now());
  if (pause <= Http2Guard::Clock::duration::zero()) return read_client();
  hear_timer_.expires_after(pause);
  hear_timer_.async_wait([self = shared_from_this()](const error_code& cancelled) {
    if (!cancelled && !self->closed_) self->read_client();
  });
}

void Http2Relay::read_client() {
  client_.async_read_some(asio::buffer(to_server_),
                          [self = shared_from_this()](const error_code& error, std::size_t size) {
                            if (self->closed_ || self->refused_) return;
                            error ? self->close() : self->on_client(size);
                          });
}

void Http2Relay::on_client(std::size_t size) {
  const auto now = Http2Guard::Clock::now();
  heard_ = std::min(heard_ + size, kPrefaceBytes);
  if (heard_ == kPrefaceBytes) slot_.used();
  const std::uint64_t resets = guard_.resets();
  const auto ok = guard_.from_client(std::span(to_server_).first(size), now);
  backoff_.count_resets(address_, guard_.resets() - resets, now);
  if (!ok) return refuse(ok.error().message, guard_.server_between_frames());
  asio::async_write(server_, asio::buffer(to_server_.data(), size),
                    [self = shared_from_this()](const error_code& error, std::size_t) {
                      if (self->closed_ || self->refused_) return;
                      error ? self->close() : self->hear();
                    });
}

void Http2Relay::read_server() {
  server_.async_read_some(asio::buffer(to_client_),
                          [self = shared_from_this()](const error_code& error, std::size_t size) {
                            if (self->closed_ || self->refused_) return;
                            error ? self->close() : self->on_server(size);
                          });
}

void Http2Relay::on_server(std::size_t size) {
  const auto now = Http2Guard::Clock::now();
  const std::uint64_t resets = guard_.resets();
  const bool between_frames = guard_.server_between_frames();
  const auto ok = guard_.from_server(std::span(to_client_).first(size), now);
  backoff_.count_resets(address_, guard_.resets() - resets, now);
  if (!ok) return refuse(ok.error().message, between_frames);
  if (deaf_ && !guard_.awaits_answers()) hear();
  std::size_t sent = 0;
  if (!client_.is_secure()) {
    // Most clients read it at once; the stall timer ends the others.
    error_code error;
    sent = socket().write_some(asio::buffer(to_client_.data(), size), error);
    if (error && error != asio::error::would_block) return close();
    if (error) sent = 0;
  }
  if (sent == size) return read_server();
  answering_ = true;
  await_taking();
  asio::async_write(client_, asio::buffer(to_client_.data() + sent, size - sent),
                    [self = shared_from_this()](const error_code& failed, std::size_t) {
                      if (!self->closed_ && !self->refused_) self->on_sent(failed.failed());
                    });
}

void Http2Relay::await_taking() {
  stall_timer_.expires_after(rules_.stall_timeout);
  stall_timer_.async_wait([self = shared_from_this()](const error_code& cancelled) {
    if (cancelled || self->closed_) return;
    self->log_.warn("closing " + self->peer_ + ": takes no answers");
    self->end_ = "takes no answers";
    self->close();
  });
}

void Http2Relay::on_sent(bool failed) {
  answering_ = false;
  error_code ignored;
  stall_timer_.cancel(ignored);
  failed ? close() : read_server();
}

void Http2Relay::refuse(const std::string& why, bool between_frames) {
  refused_ = true;
  backoff_.offend(address_, Http2Guard::Clock::now());
  log_.warn("closing " + peer_ + ": " + why);
  end_ = why;
  error_code ignored;
  server_.close(ignored);
  hear_timer_.cancel(ignored);
  // GOAWAY is valid between two frames only.
  if (answering_ || !between_frames) return close();
  last_word_ = go_away(why);
  asio::async_write(client_, asio::buffer(last_word_),
                    [self = shared_from_this()](const error_code&, std::size_t) {
                      error_code gone;
                      if (!self->closed_) self->socket().shutdown(Socket::shutdown_send, gone);
                    });
  stall_timer_.expires_after(kLinger);
  stall_timer_.async_wait([self = shared_from_this()](const error_code& cancelled) {
    if (!cancelled) self->close();
  });
  read_rest();
}

void Http2Relay::read_rest() {
  client_.async_read_some(asio::buffer(to_server_), [self = shared_from_this()](
                                                        const error_code& error, std::size_t size) {
    if (self->closed_) return;
    self->rest_ += size;
    error || self->rest_ > kMaxRestBytes ? self->close() : self->read_rest();
  });
}

}  // namespace aprsim::grpc_server
