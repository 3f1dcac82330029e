#include "protocols/modbus/limited_log.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>

namespace aprsim::protocols {

bool LimitedLog::admit(Clock::time_point now) {
  const double passed = std::chrono::duration<double>(now - refilled_).count();
  if (passed > 0) {
    tokens_ = std::min(kBurst, tokens_ + passed * kPerSecond);
    refilled_ = now;
  }
  if (tokens_ < 1) {
    ++suppressed_;
    return false;
  }
  tokens_ -= 1;
  return true;
}

void LimitedLog::info(std::string_view line) {
  if (!admit(Clock::now())) return;
  if (suppressed_ > 0) spdlog::warn("modbus: {} log lines left out", suppressed_);
  suppressed_ = 0;
  spdlog::info("modbus: {}", line);
}

void LimitedLog::warn(std::string_view line) {
  if (!admit(Clock::now())) return;
  if (suppressed_ > 0) spdlog::warn("modbus: {} log lines left out", suppressed_);
  suppressed_ = 0;
  spdlog::warn("modbus: {}", line);
}

}  // namespace aprsim::protocols
