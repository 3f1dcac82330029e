#include "protocols/modbus/limited_log.hpp"

#include <gtest/gtest.h>

namespace aprsim::modbus_server {
namespace {

TEST(LimitedLog, PassesABurstThenASteadyRate) {
  LimitedLog log;
  const auto start = LimitedLog::Clock::now() + std::chrono::seconds(1);
  int burst = 0;
  for (int i = 0; i < 1000; ++i) burst += log.admit(start) ? 1 : 0;
  EXPECT_EQ(burst, static_cast<int>(LimitedLog::kBurst));
  EXPECT_EQ(log.suppressed(), 1000U - static_cast<unsigned>(LimitedLog::kBurst));
  int later = 0;
  for (int ms = 1; ms <= 10000; ++ms) {
    later += log.admit(start + std::chrono::milliseconds(ms)) ? 1 : 0;
  }
  EXPECT_NEAR(later, 10 * LimitedLog::kPerSecond, 1);
}

}  // namespace
}  // namespace aprsim::modbus_server
