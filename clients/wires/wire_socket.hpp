#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "clients/wires/endpoints.hpp"
#include "clients/wires/tcp_socket.hpp"

struct ssl_st;

namespace aprsim::client {

/// A connected socket, encrypted by TLS 1.2 or 1.3 where that is asked for. Calls end as those of
/// TcpSocket. Thread: one at a time.
class WireSocket {
 public:
  using Time = TcpSocket::Time;

  /// `encryption` absent = none. The server's certificate names `host`. Failures: kConnection, also
  /// for a refused handshake; kUsage for texts that hold no certificate or key.
  [[nodiscard]] static Outcome<WireSocket> connect(const std::string& host, std::uint16_t port,
                                                   const std::optional<Encryption>& encryption,
                                                   Time deadline);
  /// Sends all of the bytes.
  [[nodiscard]] Outcome<void> send(std::string_view bytes, Time deadline);
  /// The bytes that have arrived, at least one.
  [[nodiscard]] Outcome<std::string> receive(Time deadline);

 private:
  struct Free {
    void operator()(ssl_st* connection) const;
  };
  explicit WireSocket(TcpSocket tcp) : tcp_(std::move(tcp)) {}
  [[nodiscard]] Outcome<void> begin_tls(const std::string& host, const Encryption& encryption,
                                        Time deadline);
  /// Goes on after a call of OpenSSL that returned `result` <= 0: sends and receives.
  [[nodiscard]] Outcome<void> go_on(int result, Time deadline);
  [[nodiscard]] Outcome<void> flush(Time deadline);

  TcpSocket tcp_;
  std::unique_ptr<ssl_st, Free> tls_;  // null = not encrypted
};

}  // namespace aprsim::client
