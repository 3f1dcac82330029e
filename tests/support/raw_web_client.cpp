#include "tests/support/raw_web_client.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdexcept>
#include <sys/socket.h>
#include <unistd.h>

namespace aprsim::test_support {
namespace {

constexpr int kDeadline_ms = 10'000;

}  // namespace

RawWebClient::RawWebClient(std::uint16_t port) : host_("127.0.0.1:" + std::to_string(port)) {
  fd_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    throw std::runtime_error("cannot connect to the web server");
  }
}

RawWebClient::~RawWebClient() { ::close(fd_); }

void RawWebClient::send(const std::string& bytes) {
  // What the peer no longer takes is part of what is tested.
  (void)::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
}

bool RawWebClient::fill() {
  pollfd ready{fd_, POLLIN, 0};
  if (::poll(&ready, 1, kDeadline_ms) <= 0) throw std::runtime_error("the web server is silent");
  char buffer[16384];
  const ssize_t size = ::recv(fd_, buffer, sizeof buffer, 0);
  if (size <= 0) return false;
  input_.append(buffer, static_cast<std::size_t>(size));
  return true;
}

std::string RawWebClient::take(std::size_t count) {
  while (input_.size() < count) {
    if (!fill()) return {};
  }
  std::string taken = input_.substr(0, count);
  input_.erase(0, count);
  return taken;
}

std::string RawWebClient::read_head() {
  std::size_t end = std::string::npos;
  while ((end = input_.find("\r\n\r\n")) == std::string::npos) {
    if (!fill()) return {};
  }
  return take(end + 4);
}

std::string RawWebClient::request(const std::string& head, const std::string& headers,
                                  bool with_body) {
  send(head + "\r\nHost: " + host_ + "\r\n" + headers + "\r\n");
  return answer(with_body);
}

std::string RawWebClient::answer(bool with_body) {
  std::string answer = read_head();
  const auto at = answer.find("Content-Length: ");
  if (with_body && at != std::string::npos) answer += take(std::stoul(answer.substr(at + 16)));
  return answer;
}

bool RawWebClient::closed(std::chrono::milliseconds deadline) {
  const auto end = std::chrono::steady_clock::now() + deadline;
  while (std::chrono::steady_clock::now() < end) {
    pollfd ready{fd_, POLLIN, 0};
    if (::poll(&ready, 1, 20) <= 0) continue;
    char buffer[16384];
    if (::recv(fd_, buffer, sizeof buffer, 0) <= 0) return true;
  }
  return false;
}

std::string RawWebClient::upgrade(const std::string& origin) {
  send("GET /ws HTTP/1.1\r\nHost: " + host_ +
       "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
       "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
       (origin.empty() ? "" : "Origin: " + origin + "\r\n") + "\r\n");
  return read_head();
}

void RawWebClient::send_frame(int opcode, const std::string& payload) {
  std::string frame(1, static_cast<char>(0x80 | opcode));
  if (payload.size() < 126) {
    frame += static_cast<char>(0x80 | payload.size());
  } else {
    frame += static_cast<char>(0x80 | 126);
    frame += static_cast<char>((payload.size() >> 8) & 0xFF);
    frame += static_cast<char>(payload.size() & 0xFF);
  }
  frame += std::string(4, '\0');  // a mask that changes nothing
  send(frame + payload);
}

void RawWebClient::send(const v1::ViewerRequest& request) {
  send_frame(2, request.SerializeAsString());
}

std::optional<v1::ViewerUpdate> RawWebClient::next(
    const std::function<bool(const v1::ViewerUpdate&)>& wanted) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(kDeadline_ms);
  while (std::chrono::steady_clock::now() < end) {
    const std::string head = take(2);
    if (head.size() < 2 || (head[0] & 0x0F) == 8) return std::nullopt;
    std::size_t size = static_cast<unsigned char>(head[1]) & 0x7FU;
    if (size >= 126) {
      const std::string length = take(size == 126 ? 2 : 8);
      size = 0;
      for (const char byte : length) size = (size << 8) | static_cast<unsigned char>(byte);
    }
    const std::string payload = take(size);
    v1::ViewerUpdate update;
    if ((head[0] & 0x0F) == 2 && update.ParseFromString(payload) && wanted(update)) return update;
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

}  // namespace aprsim::test_support
