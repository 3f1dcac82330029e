#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "tests/support/eventually.hpp"
#include "tests/support/patience.hpp"
#include "tests/support/tcp_socket.hpp"
#include "tests/unit/modbus/bytes.hpp"

namespace aprsim::modbus_server::testing {

using modbus::testing::Bytes;
using test::eventually;
using namespace std::chrono_literals;

/// A plain socket that sends bytes and receives whole replies.
class RawClient : public test::TcpSocket {
 public:
  using TcpSocket::TcpSocket;

  /// As TcpSocket's.
  bool send(const Bytes& bytes) { return TcpSocket::send(text(bytes)); }
  std::size_t send_some(const Bytes& bytes) {
    return TcpSocket::send_some(text(bytes)).value_or(0);
  }
  /// One whole reply, or nothing when the connection ends or the time is up.
  std::optional<Bytes> receive(std::chrono::milliseconds within = 5s * test::kPatience);
  /// One request and its reply.
  std::optional<Bytes> ask(const Bytes& frame, std::chrono::milliseconds within = 5s * test::kPatience);

 private:
  static std::string_view text(const Bytes& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  bool read(Bytes& into, std::size_t count, Clock::time_point deadline);
};

}  // namespace aprsim::modbus_server::testing
