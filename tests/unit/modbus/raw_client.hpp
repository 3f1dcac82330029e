#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>

#include "tests/unit/modbus/bytes.hpp"

namespace aprsim::protocols::testing {

using modbus::testing::Bytes;
using namespace std::chrono_literals;

/// A plain TCP socket to 127.0.0.1 that every wait of has a deadline.
class RawClient {
 public:
  /// receive_buffer: kernel buffer [bytes], 0 = the system's.
  explicit RawClient(std::uint16_t port, int receive_buffer = 0);
  ~RawClient();
  RawClient(RawClient&&) noexcept;
  RawClient& operator=(RawClient&&) = delete;

  /// False when the peer has gone.
  bool send(const Bytes& bytes);
  /// Sends what the kernel takes at once; how much that was.
  std::size_t send_some(const Bytes& bytes);
  /// One whole reply, or nothing when the connection ends or the time is up.
  std::optional<Bytes> receive(std::chrono::milliseconds within = 5s);
  /// One request and its reply.
  std::optional<Bytes> ask(const Bytes& frame, std::chrono::milliseconds within = 5s);
  /// Whether the server ends the connection in time; what arrives before is thrown away.
  bool ended(std::chrono::milliseconds within = 5s);
  void half_close();
  /// Ends with a reset instead of an orderly close.
  void reset();

 private:
  bool readable(std::chrono::steady_clock::time_point deadline) const;
  std::optional<Bytes> exactly(std::size_t size, std::chrono::steady_clock::time_point deadline);
  int fd_ = -1;
};

/// Waits for a condition; false when the time is up.
bool eventually(const std::function<bool()>& condition, std::chrono::milliseconds within = 5s);

}  // namespace aprsim::protocols::testing
