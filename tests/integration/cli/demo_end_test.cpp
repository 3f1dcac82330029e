#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/integration/cli/cli_commands.hpp"

namespace aprsim::test {
namespace {

std::int64_t command_id(const DaemonProcess& daemon) {
  const auto status = run_aprsim(daemon, {"crcl", "status", "--robot", "fanuc", "--json"});
  return nlohmann::json::parse(status.out).at("command_id").get<std::int64_t>();
}

TEST(UsedUpDemo, SaysSoAtOnce) {
  DaemonProcess daemon({"--speed", "max"});
  ProcessResult last;
  std::int64_t before = 0;
  int done = 0;
  // The scene has fewer gears than that.
  constexpr int kMany = 30;
  do {
    before = command_id(daemon);
    last = run_aprsim(daemon, {"demo", "--robot", "fanuc"});
  } while (last.exit_code == 0 && ++done < kMany);
  ASSERT_GE(done, 1) << last.out << last.err;
  ASSERT_LT(done, kMany);
  EXPECT_EQ(last.exit_code, 1) << last.out;
  EXPECT_NE(last.err.find("'aprsim reset' restarts the cell"), std::string::npos) << last.err;
  // A few to begin and to end with, and for each height at which something lies one refusal, or one
  // gear that is taken and put back: nothing farther out is tried.
  EXPECT_LE(command_id(daemon) - before, 80) << last.out << last.err;
  const auto reset = run_aprsim(daemon, {"reset"});
  EXPECT_EQ(reset.exit_code, 0) << reset.err;
  EXPECT_EQ(run_aprsim(daemon, {"demo", "--robot", "fanuc"}).exit_code, 0) << "as it says";
}

}  // namespace
}  // namespace aprsim::test
