#pragma once

#include <algorithm>
#include <arpa/inet.h>
#include <chrono>
#include <cstdint>
#include <poll.h>
#include <stdexcept>
#include <string>
#include <sys/socket.h>
#include <unistd.h>
#include <vector>

namespace aprsim::test {

/// One object of a frame. `seen` is false for a slot whose first five fields are not all filled:
/// readers pass over it.
struct VisionObject {
  std::string name, type;
  bool seen = false;
  double rotation_rad = 0, x_mm = 0, y_mm = 0, score = 0;
};

/// Reads a frame as APRS clients do: six fields an object, split at a comma and any blanks, empty
/// ones at the end of the line left off. Shares nothing with the code that writes it. Throws
/// std::runtime_error for anything else.
inline std::vector<VisionObject> parse_vision_line(std::string line) {
  while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.pop_back();
  std::vector<std::string> fields;
  std::size_t at = 0;
  while (at < line.size()) {
    const std::size_t comma = std::min(line.find(',', at), line.size());
    fields.push_back(line.substr(at, comma - at));
    at = comma + 1;
    while (at < line.size() && line[at] == ' ') ++at;
  }
  if (fields.size() % 6 != 0) throw std::runtime_error("not six fields an object: " + line);
  const auto number = [&](const std::string& text) {
    std::size_t used = 0;
    const double value = std::stod(text, &used);
    if (used != text.size()) throw std::runtime_error("not a number: " + text);
    return value;
  };
  std::vector<VisionObject> objects;
  for (std::size_t i = 0; i < fields.size(); i += 6) {
    VisionObject object{.name = fields[i], .type = fields[i + 5]};
    object.seen = true;
    for (std::size_t k = 0; k < 5; ++k) object.seen = object.seen && !fields[i + k].empty();
    if (object.seen) {
      object.rotation_rad = number(fields[i + 1]);
      object.x_mm = number(fields[i + 2]);
      object.y_mm = number(fields[i + 3]);
      object.score = number(fields[i + 4]);
    }
    objects.push_back(std::move(object));
  }
  return objects;
}

/// A socket on the vision feed that only ever reads. Every failure throws std::runtime_error.
class VisionClient {
 public:
  explicit VisionClient(std::uint16_t port, int receive_buffer = 0)
      : fd_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (receive_buffer > 0) {
      ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    }
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
      ::close(fd_);
      throw std::runtime_error("cannot connect");
    }
  }
  ~VisionClient() { ::close(fd_); }
  VisionClient(const VisionClient&) = delete;
  VisionClient& operator=(const VisionClient&) = delete;

  /// The next line, its line feed included.
  std::string line(std::chrono::milliseconds limit = std::chrono::seconds(10)) {
    const auto deadline = std::chrono::steady_clock::now() + limit;
    std::size_t end = 0;
    while ((end = buffer_.find('\n')) == std::string::npos) {
      if (!receive(deadline)) throw std::runtime_error("closed in the middle: " + buffer_);
    }
    std::string text = buffer_.substr(0, end + 1);
    buffer_.erase(0, end + 1);
    return text;
  }

  /// The next line that is not `before`.
  std::string line_after(const std::string& before) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (std::chrono::steady_clock::now() < deadline) {
      std::string text = line();
      if (text != before) return text;
    }
    throw std::runtime_error("always the same frame");
  }

  /// Reads what there still is; true once the other end has closed.
  bool closed(std::chrono::milliseconds limit) {
    const auto deadline = std::chrono::steady_clock::now() + limit;
    try {
      while (receive(deadline)) {
      }
      return true;
    } catch (const std::runtime_error&) {
      return false;
    }
  }

  void finish_sending() { ::shutdown(fd_, SHUT_WR); }
  void say(const std::string& text) {
    if (::send(fd_, text.data(), text.size(), MSG_NOSIGNAL) < 0) throw std::runtime_error("send");
  }

 private:
  /// False at the end of the stream; throws at the deadline.
  bool receive(std::chrono::steady_clock::time_point deadline) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        deadline - std::chrono::steady_clock::now());
    pollfd wait{fd_, POLLIN, 0};
    if (left.count() < 0 || ::poll(&wait, 1, static_cast<int>(left.count())) != 1) {
      throw std::runtime_error("nothing came in time");
    }
    char bytes[4096];
    const auto size = ::recv(fd_, bytes, sizeof bytes, 0);
    if (size <= 0) return false;
    buffer_.append(bytes, static_cast<std::size_t>(size));
    return true;
  }

  int fd_;
  std::string buffer_;
};

}  // namespace aprsim::test
