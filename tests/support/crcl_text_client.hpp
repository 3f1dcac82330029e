#pragma once

#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <thread>

#include "crcl/schema.hpp"
#include "tests/support/tcp_socket.hpp"

namespace aprsim::test {

/// A CRCL client that knows nothing of our codec: text out, text in, as PROTOCOL's Java client
/// behaves. Every failure throws.
class CrclTextClient {
 public:
  explicit CrclTextClient(std::uint16_t port) : socket_(port) {}

  /// Sends one command of type `type` with the next id and `fields` after the id.
  std::int64_t send(const std::string& type, const std::string& fields = "") {
    const std::int64_t id = ++id_;
    write(type, id, fields);
    return id;
  }

  /// Sends a text as it is.
  void raw(const std::string& text) {
    if (!socket_.send(text)) throw std::runtime_error("the server has closed or does not read");
  }

  /// One command as it goes over the wire.
  static std::string document(const std::string& type, std::int64_t id,
                              const std::string& fields = "") {
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?><CRCLCommandInstance "
           "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\"><CRCLCommand xsi:type=\"" +
           type + "\"><CommandID>" + std::to_string(id) + "</CommandID>" + fields +
           "</CRCLCommand></CRCLCommandInstance>";
  }

  /// The end position of a move, the tool pointing down [mm].
  static std::string tool_down(double x_mm, double y_mm, double z_mm) {
    const std::string i = "<I>1</I><J>0</J><K>0</K>", down = "<I>0</I><J>0</J><K>-1</K>";
    return "<EndPosition><Point><X>" + std::to_string(x_mm) + "</X><Y>" + std::to_string(y_mm) +
           "</Y><Z>" + std::to_string(z_mm) + "</Z></Point><XAxis>" + i + "</XAxis><ZAxis>" + down +
           "</ZAxis></EndPosition>";
  }

  /// Closes without a word, as a client that dies.
  void vanish() { socket_.reset(); }

  /// Asks for the status and returns it as text, which the schema must allow.
  std::string status() {
    write("GetStatusType", id_, "");
    static const std::string kEnd = "</CRCLStatus>";
    const auto deadline = TcpSocket::Clock::now() + std::chrono::seconds(30);
    std::size_t end = 0;
    while ((end = buffer_.find(kEnd)) == std::string::npos) {
      const std::string bytes = socket_.receive(deadline);
      if (bytes.empty()) throw std::runtime_error("closed while a status was expected");
      buffer_ += bytes;
    }
    std::string text = buffer_.substr(0, end + kEnd.size());
    buffer_.erase(0, end + kEnd.size());
    if (const auto fault = crcl::schema_fault(text)) {
      throw std::runtime_error(fault->message() + ": " + text);
    }
    return text;
  }

  /// Polls until that id is done and returns the status; throws with it on an error or deadline.
  std::string wait_done(std::int64_t id, std::chrono::seconds deadline = std::chrono::seconds(30)) {
    const auto end = std::chrono::steady_clock::now() + deadline;
    while (true) {
      const std::string text = status();
      if (field(text, "CommandID") == std::to_string(id)) {
        const std::string state = field(text, "CommandState");
        if (state == "CRCL_Done") return text;
        if (state == "CRCL_Error") throw std::runtime_error(text);
      }
      if (std::chrono::steady_clock::now() > end) throw std::runtime_error("not done: " + text);
      std::this_thread::sleep_for(std::chrono::milliseconds(2));  // the cell needs the processor
    }
  }

  std::string run(const std::string& type, const std::string& fields = "") {
    return wait_done(send(type, fields));
  }

  /// Text of the first element of that name after `from`; empty when there is none.
  static std::string field(const std::string& text, const std::string& name, std::size_t from = 0) {
    const auto open = text.find("<" + name + ">", from);
    if (open == std::string::npos) return "";
    const auto start = open + name.size() + 2;
    return text.substr(start, text.find('<', start) - start);
  }
  static double number(const std::string& text, const std::string& name, std::size_t from = 0) {
    return std::stod(field(text, name, from));
  }

 private:
  void write(const std::string& type, std::int64_t id, const std::string& fields) {
    raw(document(type, id, fields));
  }

  TcpSocket socket_;
  std::string buffer_;
  std::int64_t id_ = 3;
};

}  // namespace aprsim::test
