#include "protocols/net/limited_log.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>

#include "world/base/utf8_text.hpp"

namespace aprsim::protocols {
namespace {

/// Control characters of ASCII and of Latin-1.
bool is_control(std::string_view character) {
  const auto first = static_cast<unsigned char>(character[0]);
  if (character.size() == 1) return first < 0x20 || first == 0x7F;
  return first == 0xC2 && static_cast<unsigned char>(character[1]) < 0xA0;
}

}  // namespace

std::string log_text(std::string_view text, std::size_t limit) {
  std::string out;
  while (!text.empty()) {
    if (out.size() >= limit) return out + "...";
    const std::string_view character = text.substr(0, std::max<std::size_t>(utf8_length(text), 1));
    text.remove_prefix(character.size());
    if (character == "\n") {
      out += "\\n";
    } else if (utf8_length(character) == 0 || is_control(character)) {
      for (const char byte : character) {
        out += fmt::format("\\x{:02x}", static_cast<unsigned char>(byte));
      }
    } else {
      out += character;
    }
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
