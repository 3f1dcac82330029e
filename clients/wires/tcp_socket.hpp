#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "clients/wires/cancellation.hpp"
#include "clients/wires/outcome.hpp"

namespace aprsim::client {

/// A connected TCP socket whose every call ends by a deadline (kTimeout) or when it is cancelled
/// (kInterrupted). A connection that cannot be made or has ended is kConnection. Move-only.
/// Thread: one at a time.
class TcpSocket {
 public:
  /// Patience of the sessions of this library while they connect.
  static constexpr std::chrono::seconds kConnectTimeout{5};

  using Time = std::chrono::steady_clock::time_point;

  /// `host`: a name or an address. A host that does not answer in time is kConnection.
  [[nodiscard]] static Outcome<TcpSocket> connect(const std::string& host, std::uint16_t port,
                                                  Time deadline, const Cancelled& cancelled = {});
  TcpSocket(TcpSocket&& other) noexcept;
  TcpSocket& operator=(TcpSocket&& other) noexcept;
  ~TcpSocket();

  /// Sends all of the bytes.
  [[nodiscard]] Outcome<void> send(std::string_view bytes, Time deadline,
                                   const Cancelled& cancelled = {});
  /// The bytes that have arrived, at least one. A closed connection is kConnection.
  [[nodiscard]] Outcome<std::string> receive(Time deadline, const Cancelled& cancelled = {});

 private:
  TcpSocket(int fd, std::string peer) : fd_(fd), peer_(std::move(peer)) {}
  [[nodiscard]] Outcome<void> wait(short events, Time deadline, const Cancelled& cancelled) const;

  int fd_ = -1;
  std::string peer_;
};

}  // namespace aprsim::client
