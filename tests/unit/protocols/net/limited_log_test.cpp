#include "protocols/net/limited_log.hpp"

#include <gtest/gtest.h>

namespace aprsim::protocols {
namespace {

TEST(LimitedLog, PassesABurstThenASteadyRate) {
  LimitedLog log("test");
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

/// No peer forges lines or commands the terminal of whoever reads them.
TEST(LogText, IsOneLineOfPlainText) {
  EXPECT_EQ(log_text("plain text, 2.5 mm"), "plain text, 2.5 mm");
  EXPECT_EQ(log_text("a\n[info] forged\r\x1b[2J\x7f"), "a\\n[info] forged\\x0d\\x1b[2J\\x7f");
  EXPECT_EQ(log_text("M\xc3\xbcnchen \xe2\x82\xac"), "M\xc3\xbcnchen \xe2\x82\xac");
  EXPECT_EQ(log_text("\xff\xc3("), "\\xff\\xc3(");
  EXPECT_EQ(log_text("\xc2\x9b"), "\\xc2\\x9b") << "a control character of Latin-1";
  EXPECT_EQ(log_text(std::string(1000, 'x')), std::string(kMaxLogText, 'x') + "...");
  EXPECT_LE(log_text(std::string(1000, '\x01')).size(), kMaxLogText + 8);
  EXPECT_EQ(log_text(std::string("a\0b", 3)), "a\\x00b");
}

}  // namespace
}  // namespace aprsim::protocols
