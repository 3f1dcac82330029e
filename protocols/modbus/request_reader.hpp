#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "modbus/request_validator.hpp"

namespace aprsim::modbus_server {

/// Cuts the bytes of one client into requests. Keeps sixteen of the longest ones: a client that
/// pipelines more waits in the kernel's buffer. Thread: one at a time.
class RequestReader {
 public:
  explicit RequestReader(const modbus::RequestRules& rules) : rules_(rules) {}

  /// Space for the next bytes; empty while the reader is full.
  [[nodiscard]] std::span<std::uint8_t> room() { return std::span(bytes_).subspan(size_); }
  /// So many bytes have been read into room().
  void append(std::size_t size) { size_ += size; }
  /// Name of another protocol that the stream begins with; empty = it may be Modbus. Judges once,
  /// as soon as there are enough bytes.
  [[nodiscard]] std::string_view foreign_protocol();

  /// The next request, which refers to this reader until compact(). Incomplete and broken ones stay
  /// where they are.
  [[nodiscard]] modbus::ValidatedRequest next();
  /// The last call of next() found no complete request.
  [[nodiscard]] bool incomplete() const { return incomplete_; }
  /// Bytes that next() has not used.
  [[nodiscard]] std::span<const std::uint8_t> rest() const {
    return std::span(bytes_).subspan(used_, size_ - used_);
  }
  /// Gives back the space of used bytes; not while a read into room() is under way.
  void compact();

 private:
  const modbus::RequestRules& rules_;
  std::array<std::uint8_t, 16 * modbus::kMaxAduSize> bytes_;
  std::size_t size_ = 0, used_ = 0;
  bool judged_ = false;  // whether it is Modbus
  bool incomplete_ = true;
};

}  // namespace aprsim::modbus_server
