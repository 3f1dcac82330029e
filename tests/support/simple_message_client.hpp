#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "protocols/simple_message/codec/message_codec.hpp"
#include "tests/support/tcp_socket.hpp"

namespace aprsim::test {

/// A client of one Simple Message port in network order.
class SimpleMessageClient {
 public:
  explicit SimpleMessageClient(std::uint16_t port) : socket_(port) {}

  void send(const simple_message::Message& message) {
    send_bytes(simple_message::encode(message, simple_message::ByteOrder::kBig));
  }
  void send_bytes(const std::string& bytes) {
    if (!socket_.send(bytes)) throw std::runtime_error("the server does not read");
  }
  /// The next message, as its length cuts it. Throws when none comes in time.
  simple_message::Message receive() {
    const std::string bytes = receive_bytes();
    auto message = simple_message::decode_reply(as_bytes(bytes), simple_message::ByteOrder::kBig);
    if (!message) throw std::runtime_error(message.error().message);
    return *std::move(message);
  }
  std::string receive_bytes() {
    using namespace simple_message;
    fill(kLengthSize);
    const auto length = decode_word(as_bytes(input_).first<kLengthSize>(), ByteOrder::kBig) + 4;
    return take(static_cast<std::size_t>(length));
  }
  /// So many bytes.
  std::string take(std::size_t size) {
    fill(size);
    std::string bytes = input_.substr(0, size);
    input_.erase(0, size);
    return bytes;
  }
  template <typename Body>
  Body receive_body() {
    return std::get<Body>(receive().body);
  }
  /// Sends a request and returns the body of its reply.
  template <typename Body>
  Body ask(simple_message::MessageType type, simple_message::Body body) {
    send({type, simple_message::Communication::kServiceRequest, simple_message::ReplyCode::kNone,
          std::move(body)});
    return receive_body<Body>();
  }
  /// Whether something has come, or comes in time.
  [[nodiscard]] bool readable(std::chrono::milliseconds within) {
    return !input_.empty() || socket_.readable(TcpSocket::Clock::now() + within);
  }
  [[nodiscard]] bool ended() { return socket_.ended(); }
  TcpSocket& socket() { return socket_; }

 private:
  static std::span<const std::uint8_t> as_bytes(const std::string& text) {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
  }
  void fill(std::size_t size) {
    const auto deadline = TcpSocket::Clock::now() + std::chrono::seconds(10);
    while (input_.size() < size) {
      const std::string more = socket_.receive(deadline);
      if (more.empty()) throw std::runtime_error("the server has closed");
      input_ += more;
    }
  }

  TcpSocket socket_;
  std::string input_;
};

}  // namespace aprsim::test
