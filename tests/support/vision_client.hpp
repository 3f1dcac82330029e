#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/tcp_socket.hpp"

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
  static constexpr std::chrono::seconds kPatience{10};

  explicit VisionClient(std::uint16_t port, int receive_buffer = 0, const std::string& from = "")
      : socket_(port, receive_buffer, from) {}

  /// The next line, its line feed included.
  std::string line(std::chrono::milliseconds limit = kPatience) {
    const auto deadline = TcpSocket::Clock::now() + limit;
    std::size_t end = 0;
    while ((end = buffer_.find('\n')) == std::string::npos) {
      const std::string bytes = socket_.receive(deadline);
      if (bytes.empty()) throw std::runtime_error("closed in the middle: " + buffer_);
      buffer_ += bytes;
    }
    std::string text = buffer_.substr(0, end + 1);
    buffer_.erase(0, end + 1);
    return text;
  }

  /// Throws away what has come, without a wait.
  void take() {
    std::array<char, 4096> bytes{};
    while (socket_.receive_some(bytes).value_or(0) > 0) {
    }
  }

  /// The next line that is not `before`.
  std::string line_after(const std::string& before) {
    const auto deadline = TcpSocket::Clock::now() + kPatience;
    while (TcpSocket::Clock::now() < deadline) {
      std::string text = line();
      if (text != before) return text;
    }
    throw std::runtime_error("always the same frame");
  }

  /// Reads what there still is; true once the other end has closed.
  bool closed(std::chrono::milliseconds limit) { return socket_.ended(limit); }

  void finish_sending() { socket_.finish_sending(); }
  void say(const std::string& text) {
    if (!socket_.send(text)) throw std::runtime_error("send");
  }

 private:
  TcpSocket socket_;
  std::string buffer_;
};

}  // namespace aprsim::test
