#include "protocols/net/limited_log.hpp"

#include <spdlog/spdlog.h>

namespace aprsim::protocols {
namespace {

/// Length of the well-formed UTF-8 character at the start of `text`; 0 = none.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (byte(0) < 0x80) return 1;
  const std::size_t length = byte(0) >= 0xF0 ? 4 : byte(0) >= 0xE0 ? 3 : 2;
  if (byte(0) < 0xC2 || byte(0) > 0xF4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) return 0;
  }
  // Control characters of Latin-1, and overlong forms.
  if (byte(0) == 0xC2 && byte(1) < 0xA0) return 0;
  if ((byte(0) == 0xE0 && byte(1) < 0xA0) || (byte(0) == 0xF0 && byte(1) < 0x90)) return 0;
  return length;
}

}  // namespace

std::string log_text(std::string_view text, std::size_t limit) {
  std::string out;
  while (!text.empty()) {
    if (out.size() >= limit) return out + "...";
    const std::size_t length = utf8_length(text);
    const auto first = static_cast<unsigned char>(text[0]);
    if (first == '\n') {
      out += "\\n";
    } else if (length == 0 || first < 0x20 || first == 0x7F) {
      out += fmt::format("\\x{:02x}", first);
    } else {
      out += text.substr(0, length);
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

bool LimitedLog::admit(Clock::time_point now) {
  if (limit_.admit(now)) return true;
  ++suppressed_;
  return false;
}

bool LimitedLog::admit_line() {
  if (!admit(Clock::now())) return false;
  if (suppressed_ > 0) spdlog::warn("{}: {} log lines suppressed", name_, suppressed_);
  suppressed_ = 0;
  return true;
}

void LimitedLog::info(std::string_view line) {
  if (admit_line()) spdlog::info("{}: {}", name_, log_text(line));
}

void LimitedLog::warn(std::string_view line) {
  if (admit_line()) spdlog::warn("{}: {}", name_, log_text(line));
}

}  // namespace aprsim::protocols
