#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "crcl/framer.hpp"
#include "crcl/status.hpp"
#include "tests/support/tcp_socket.hpp"

namespace aprsim::crcl_server {

/// A blocking CRCL client over a real socket. Throws std::runtime_error when the server does not
/// answer within ten seconds or not as it must.
class TestClient {
 public:
  /// receive_buffer and from as TcpSocket's.
  explicit TestClient(std::uint16_t port, int receive_buffer = 0, const std::string& from = "")
      : socket_(port, receive_buffer, from) {}

  void send(std::string_view bytes);
  /// One command of the given type.
  void command(std::int64_t id, const std::string& type, const std::string& body = "");
  /// Sends GetStatus with an id that must not matter and reads one status.
  crcl::Status status();
  /// Reads one status that has been asked for already.
  crcl::Status read_status();
  /// As read_status(), the document itself. Throws when the schema does not allow it.
  std::string read_document();
  /// Asks until the status satisfies the condition.
  template <typename Condition>
  crcl::Status wait_for(Condition condition) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (true) {
      crcl::Status now = status();
      if (condition(now)) return now;
      if (std::chrono::steady_clock::now() > deadline) fail("the condition did not come true");
    }
  }

  /// Nothing more will be sent; reading goes on.
  void finish_sending() { socket_.finish_sending(); }
  /// Waits for the end of the stream; throws when anything else comes.
  void expect_closed();
  /// True when bytes are there to be read after so long.
  bool readable(std::chrono::milliseconds wait);
  /// Closes at once with a reset.
  void reset() { socket_.reset(); }

 private:
  [[noreturn]] static void fail(const std::string& what);
  std::string receive();

  test::TcpSocket socket_;
  crcl::Framer framer_ = crcl::Framer::for_statuses();
};

}  // namespace aprsim::crcl_server
