#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "modbus/request_validator.hpp"

namespace aprsim::modbus_server {

/// Cuts the bytes of one client into requests. Its buffer holds sixteen of the longest ones;
/// further bytes wait in the kernel's buffer. Thread: one at a time.
class RequestReader {
 public:
  explicit RequestReader(const modbus::RequestRules& rules) : rules_(rules) {}

  /// Space for the next bytes; empty while the reader is full.
  [[nodiscard]] std::span<std::uint8_t> room() { return std::span(bytes_).subspan(size_); }
  /// Records that this many bytes were read into room().
  void append(std::size_t size) { size_ += size; }
  /// Name of another protocol at the beginning of the stream; empty = it may be Modbus. Decided
  /// once, as soon as there are enough bytes.
  [[nodiscard]] std::string_view foreign_protocol();

  /// The next request; it refers to this reader until compact(). Incomplete and broken ones are not
  /// consumed.
  [[nodiscard]] modbus::ValidatedRequest next();
  /// Whether the last call of next() found no complete request.
  [[nodiscard]] bool incomplete() const { return incomplete_; }
  /// Bytes that next() has not consumed.
  [[nodiscard]] std::span<const std::uint8_t> rest() const {
    return std::span(bytes_).subspan(used_, size_ - used_);
  }
  /// Whether any complete request that next() has not consumed satisfies the condition.
  template <typename Condition>
  [[nodiscard]] bool any_waiting(const Condition& condition) const {
    auto left = rest();
    while (true) {
      const modbus::ValidatedRequest request = modbus::validate_request(left, rules_);
      const bool complete = request.verdict != modbus::Verdict::kIncomplete &&
                            request.verdict != modbus::Verdict::kBroken;
      if (!complete) return false;
      if (condition(request)) return true;
      left = left.subspan(request.adu.size());
    }
  }
  /// Frees the space of consumed bytes; not during a read into room().
  void compact();

 private:
  const modbus::RequestRules& rules_;
  std::array<std::uint8_t, 16 * modbus::kMaxAduSize> bytes_;
  std::size_t size_ = 0, used_ = 0;
  bool judged_ = false;  // whether it is Modbus
  bool incomplete_ = true;
};

}  // namespace aprsim::modbus_server
