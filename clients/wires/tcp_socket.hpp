#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "clients/wires/outcome.hpp"

namespace aprsim::client {

/// A connected TCP socket whose every call ends by a deadline, or when interrupted. Move-only.
class TcpSocket {
 public:
  using Time = std::chrono::steady_clock::time_point;

  [[nodiscard]] static Outcome<TcpSocket> connect(const std::string& host, std::uint16_t port,
                                                  Time deadline);
  TcpSocket(TcpSocket&& other) noexcept;
  TcpSocket& operator=(TcpSocket&& other) noexcept;
  ~TcpSocket();

  [[nodiscard]] Outcome<void> send(std::string_view bytes, Time deadline);
  /// What has arrived, at least one byte. A closed connection is a failure.
  [[nodiscard]] Outcome<std::string> receive(Time deadline);

 private:
  TcpSocket(int fd, std::string peer) : fd_(fd), peer_(std::move(peer)) {}
  [[nodiscard]] Outcome<void> wait(short events, Time deadline) const;

  int fd_ = -1;
  std::string peer_;
};

}  // namespace aprsim::client
