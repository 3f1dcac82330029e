#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace aprsim::test {

/// A TCP socket to 127.0.0.1 whose every wait has a deadline; what goes over it is the caller's.
class TcpSocket {
 public:
  using Clock = std::chrono::steady_clock;

  /// Connects; throws std::runtime_error when it cannot. receive_buffer: the kernel's [bytes],
  /// 0 = the system's. It is set before connecting: one that shrank later would take back what the
  /// peer has been promised, and acknowledgements would be lost with it.
  /// from: this end's address, one of 127.0.0.0/8; empty = 127.0.0.1.
  explicit TcpSocket(std::uint16_t port, int receive_buffer = 0, const std::string& from = "");
  ~TcpSocket();
  TcpSocket(TcpSocket&& other) noexcept;
  TcpSocket& operator=(TcpSocket&&) = delete;

  /// Sends everything; false when the peer has gone or does not read in time.
  bool send(std::string_view bytes, std::chrono::milliseconds within = std::chrono::seconds(10));
  /// Sends what the kernel takes at once; how much that was, nothing when the peer has gone.
  std::optional<std::size_t> send_some(std::string_view bytes);

  /// Waits for something to read, be it the end.
  [[nodiscard]] bool readable(Clock::time_point deadline) const;
  /// Received bytes, at least one; empty at the end of the stream. Throws std::runtime_error
  /// when nothing comes in time.
  [[nodiscard]] std::string receive(Clock::time_point deadline);
  /// Copies bytes that have arrived into `buffer`; 0 = the end of the stream, nothing = not a byte
  /// yet.
  [[nodiscard]] std::optional<std::size_t> receive_some(std::span<char> buffer);
  /// Whether the peer ends the stream in time; what comes before is thrown away.
  [[nodiscard]] bool ended(std::chrono::milliseconds within = std::chrono::seconds(10));

  /// Nothing more will be sent; reading goes on.
  void finish_sending();
  /// Closes with a reset instead of an orderly end.
  void reset();

  /// To wait for many at once; stays this object's.
  [[nodiscard]] int fd() const { return fd_; }

 private:
  int fd_;
};

}  // namespace aprsim::test
