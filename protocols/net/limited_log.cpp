#include "protocols/net/limited_log.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>

#include "world/base/utf8.hpp"

namespace aprsim::protocols {

std::string log_text(std::string_view text, std::size_t limit) {
  std::string out;
  while (!text.empty()) {
    if (out.size() >= limit) return out + "...";
    const std::size_t length = std::max<std::size_t>(utf8::length(text), 1);
    const std::string_view character = text.substr(0, length);
    out += character == "\n" ? "\\n" : utf8::printable(character);
    text.remove_prefix(length);
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
