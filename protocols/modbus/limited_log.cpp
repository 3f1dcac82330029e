#include "protocols/modbus/limited_log.hpp"

#include <spdlog/spdlog.h>

namespace aprsim::modbus_server {

bool LimitedLog::admit(Clock::time_point now) {
  if (limit_.admit(now)) return true;
  ++suppressed_;
  return false;
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

}  // namespace aprsim::modbus_server
