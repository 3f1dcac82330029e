#include "server/operations/stop_deadline.hpp"

#include <cstdio>
#include <cstdlib>
#include <unistd.h>

#include <gtest/gtest.h>

namespace aprsim::server {
namespace {

using namespace std::chrono_literals;

[[noreturn]] void hang() {
  while (true) ::pause();
}

class StopDeadlineDeathTest : public testing::Test {
 protected:
  void SetUp() override { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST_F(StopDeadlineDeathTest, FinishesAndEndsAProcessThatHangs) {
  EXPECT_EXIT(
      {
        const StopDeadline deadline([] { std::fputs("finished", stderr); }, 10ms, 60s);
        hang();
      },
      testing::ExitedWithCode(EXIT_SUCCESS), "finished");
}

TEST_F(StopDeadlineDeathTest, EndsAProcessWhoseFinishHangs) {
  EXPECT_EXIT(
      {
        const StopDeadline deadline([] { hang(); }, 10ms, 10ms);
        hang();
      },
      testing::ExitedWithCode(EXIT_SUCCESS), "");
}

TEST_F(StopDeadlineDeathTest, OnceDestroyedEndsTheProcessWithoutFinishing) {
  EXPECT_EXIT(
      {
        {
          const StopDeadline deadline([] { std::fputs("finished", stderr); }, 200ms, 10ms);
        }
        hang();
      },
      testing::ExitedWithCode(EXIT_SUCCESS), "^$");
}

}  // namespace
}  // namespace aprsim::server
