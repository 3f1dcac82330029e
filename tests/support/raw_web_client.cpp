#include "tests/support/raw_web_client.hpp"

#include <stdexcept>

#include "tests/support/patience.hpp"

namespace aprsim::test {
namespace {

constexpr std::chrono::seconds kDeadline = kPatience * std::chrono::seconds(10);
constexpr int kBinary = 2, kClose = 8, kPing = 9, kPong = 10;  // RFC 6455, section 5.2

}  // namespace

RawWebClient::RawWebClient(std::uint16_t port)
    : socket_(port), host_("127.0.0.1:" + std::to_string(port)) {}

void RawWebClient::send(const std::string& bytes) {
  // A send that the peer refuses is part of the test.
  static_cast<void>(socket_.send(bytes, kDeadline));
}

bool RawWebClient::fill() {
  const std::string bytes = socket_.receive(test::TcpSocket::Clock::now() + kDeadline);
  input_ += bytes;
  return !bytes.empty();
}

std::string RawWebClient::read(std::size_t count) {
  while (input_.size() < count) {
    if (!fill()) return {};
  }
  std::string bytes = input_.substr(0, count);
  input_.erase(0, count);
  return bytes;
}

std::string RawWebClient::read_head() {
  std::size_t end = std::string::npos;
  while ((end = input_.find("\r\n\r\n")) == std::string::npos) {
    if (!fill()) return {};
  }
  return read(end + 4);
}

std::string RawWebClient::request(const std::string& head, const std::string& headers,
                                  bool with_body) {
  send(head + "\r\nHost: " + host_ + "\r\n" + headers + "\r\n");
  return answer(with_body);
}

std::string RawWebClient::answer(bool with_body) {
  std::string answer = read_head();
  const auto at = answer.find("Content-Length: ");
  if (with_body && at != std::string::npos) answer += read(std::stoul(answer.substr(at + 16)));
  return answer;
}

std::string RawWebClient::upgrade(const std::string& origin) {
  send("GET /ws HTTP/1.1\r\nHost: " + host_ +
       "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
       "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
       (origin.empty() ? "" : "Origin: " + origin + "\r\n") + "\r\n");
  const std::string head = read_head();
  upgraded_ = head.starts_with("HTTP/1.1 101");
  return head;
}

void RawWebClient::send_frame(int opcode, const std::string& payload) {
  std::string frame(1, static_cast<char>(0x80 | opcode));
  if (payload.size() < 126) {
    frame += static_cast<char>(0x80 | payload.size());
  } else {
    const int bytes = payload.size() < 65536 ? 2 : 8;
    frame += static_cast<char>(0x80 | (bytes == 2 ? 126 : 127));
    for (int i = bytes; i-- > 0;) frame += static_cast<char>((payload.size() >> (8 * i)) & 0xFF);
  }
  frame += std::string(4, '\0');  // a mask that changes nothing
  send(frame + payload);
}

void RawWebClient::send(const v1::ViewerRequest& request) {
  send_frame(2, request.SerializeAsString());
}

std::optional<std::string> RawWebClient::message() {
  for (;;) {
    const std::string head = read(2);
    if (head.size() < 2) return std::nullopt;
    const int opcode = head[0] & 0x0F;
    std::size_t size = static_cast<unsigned char>(head[1]) & 0x7FU;
    if (size >= 126) {
      const std::string length = read(size == 126 ? 2 : 8);
      size = 0;
      for (const char byte : length) size = (size << 8) | static_cast<unsigned char>(byte);
    }
    std::string payload = read(size);
    switch (opcode) {
      case kClose:
        send_frame(kClose, payload);
        return std::nullopt;
      case kPing:
        send_frame(kPong, payload);
        break;
      case kBinary:
        return payload;
      default:
        break;
    }
  }
}

bool RawWebClient::closed() {
  while (upgraded_ && message()) {
  }
  return socket_.ended(kDeadline);
}

std::optional<v1::ViewerUpdate> RawWebClient::next(
    const std::function<bool(const v1::ViewerUpdate&)>& wanted) {
  const auto end = std::chrono::steady_clock::now() + kDeadline;
  while (std::chrono::steady_clock::now() < end) {
    const auto payload = message();
    if (!payload) return std::nullopt;
    v1::ViewerUpdate update;
    if (update.ParseFromString(*payload) && wanted(update)) return update;
  }
  throw std::runtime_error("the update that was waited for did not come");
}

v1::Outcome RawWebClient::ask(v1::ViewerRequest request) {
  request.set_id(++last_id_);
  send(request);
  const auto update = next([&](const v1::ViewerUpdate& u) {
    return u.has_outcome() && u.outcome().id() == request.id();
  });
  if (!update) throw std::runtime_error("the web server closed instead of answering");
  return update->outcome();
}

}  // namespace aprsim::test
