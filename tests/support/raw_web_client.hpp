#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "aprsim/v1/web.pb.h"
#include "tests/support/tcp_socket.hpp"

namespace aprsim::test {

/// An HTTP and WebSocket client of bytes and nothing else, so that tests can also be rude.
/// Pings and closings are answered whenever it reads. Everything that takes longer than ten seconds
/// throws.
class RawWebClient {
 public:
  explicit RawWebClient(std::uint16_t port);

  void send(const std::string& bytes);
  /// Sends a request with this head ("GET / HTTP/1.1") and headers besides Host; returns the answer
  /// with its body.
  std::string request(const std::string& head, const std::string& headers = "",
                      bool with_body = true);
  /// The next answer to what has been sent.
  std::string answer(bool with_body = true);
  /// True once the peer has closed; false when it has not within ten seconds.
  bool closed();

  /// The upgrade; returns the answer's head. `origin` empty = no such header.
  std::string upgrade(const std::string& origin = "");
  void send(const v1::ViewerRequest& request);
  void send_frame(int opcode, const std::string& payload);
  /// The next update for which `wanted` holds; others are passed over. Nullopt when the server
  /// closes.
  std::optional<v1::ViewerUpdate> next(const std::function<bool(const v1::ViewerUpdate&)>& wanted);
  /// Sends the request with an id and returns its outcome.
  v1::Outcome ask(v1::ViewerRequest request);

  [[nodiscard]] const std::string& host() const { return host_; }

 private:
  bool fill();
  std::string read(std::size_t count);
  std::string read_head();
  /// The next message; nullopt when the server closes.
  std::optional<std::string> message();

  test::TcpSocket socket_;
  bool upgraded_ = false;
  std::string host_;
  std::string input_;
  std::uint32_t last_id_ = 0;
};

}  // namespace aprsim::test
