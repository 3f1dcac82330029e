// Outputs of aprsim: files that it must not destroy, streams that it cannot write.

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/integration/cli/cli_commands.hpp"
#include "tests/support/cell_client.hpp"
#include "tests/support/temporary_directory.hpp"
#include "tests/support/terminal_process.hpp"

namespace aprsim::test {
namespace {

std::string bytes_of(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A shell's command; "$0" is aprsim, "$1" the ports file.
ProcessResult in_shell(const std::string& script, const std::string& ports_file = "") {
  return run_process({"sh", "-c", script, std::string(APRSIM_BIN_DIR) + "/aprsim", ports_file},
                     std::chrono::seconds(60));
}

TEST(Output, ThatCannotBeWrittenIsAFailure) {
  const DaemonProcess daemon({"--speed", "max"});
  for (const std::string command :
       {"conveyor map", "--help", "manual", "completion bash", "scenario list",
        "status --ports-file \"$1\"", "status --json --ports-file \"$1\"",
        "watch --count 1 --ports-file \"$1\"", "save a --ports-file \"$1\""}) {
    const auto full = in_shell("exec \"$0\" " + command + " > /dev/full", daemon.ports_file());
    EXPECT_EQ(full.exit_code, 1) << command << full.err;
    EXPECT_NE(full.err.find("cannot write the output: No space left on device"), std::string::npos)
        << command << ": " << full.err;
    const auto closed = in_shell("exec \"$0\" " + command + " >&-", daemon.ports_file());
    EXPECT_EQ(closed.exit_code, 1) << command << closed.err;
  }
}

TEST(Output, AReplayLeavesItsJournalsAlone) {
  const TemporaryDirectory directory;
  const std::string journal = directory.path() + "/run.journal";
  {
    DaemonProcess daemon({"--speed", "stepped", "--journal", journal});
    CellClient(daemon.port("grpc")).step(500);
    EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  }
  const std::string before = bytes_of(journal);
  ASSERT_GT(before.size(), 1000U);
  std::filesystem::create_hard_link(journal, directory.path() + "/other");
  const std::string daemon = std::string(APRSIM_BIN_DIR) + "/aprsimd";
  for (const char* motion : {"/run.journal", "/./run.journal", "/other"}) {
    const auto refused =
        run_process({daemon, "--replay", journal, "--motion", directory.path() + motion},
                    std::chrono::seconds(60));
    EXPECT_EQ(refused.exit_code, 2) << refused.out << refused.err;
    EXPECT_NE(refused.err.find("is the same file as the input"), std::string::npos) << refused.err;
  }
  const std::string aprsim = std::string(APRSIM_BIN_DIR) + "/aprsim";
  for (const std::string option : {"--mcap", "--html"}) {
    const auto refused = run_process({aprsim, "trace", "export", journal, option, journal});
    EXPECT_EQ(refused.exit_code, 2) << refused.out;
  }
  EXPECT_EQ(bytes_of(journal), before);
}

TEST(Output, JsonMayBeAskedForBeforeTheCommand) {
  const DaemonProcess daemon({"--speed", "max"});
  const auto status = run_process({std::string(APRSIM_BIN_DIR) + "/aprsim", "--json", "status",
                                   "--ports-file", daemon.ports_file()});
  EXPECT_EQ(status.out.find('\n'), status.out.size() - 1) << status.out;
  EXPECT_TRUE(nlohmann::json::parse(status.out, nullptr, false).is_object()) << status.out;
}

TEST(Output, AProxyOfTheEnvironmentIsNotForTheOwnMachine) {
  const DaemonProcess daemon({"--speed", "max"});
  for (const std::string variable : {"http_proxy", "https_proxy", "grpc_proxy"}) {
    const auto saved = in_shell("unset no_proxy no_grpc_proxy; export " + variable +
                                    "=http://127.0.0.1:1; exec \"$0\" save a --ports-file \"$1\"",
                                daemon.ports_file());
    EXPECT_EQ(saved.exit_code, 0) << variable << saved.err;
  }
}

TEST(Output, ATextThatIsNoUtf8IsRefusedWithItsField) {
  const DaemonProcess daemon({"--speed", "max"});
  const auto saved =
      in_shell("exec \"$0\" save \"$(printf 'x\\377')\" --ports-file \"$1\"", daemon.ports_file());
  EXPECT_EQ(saved.exit_code, 2);
  EXPECT_NE(saved.err.find("name: found \"x\\xff\", expected UTF-8"), std::string::npos)
      << saved.err;
}

TEST(Output, AnInterruptedRunLeavesTheCellAsItWas) {
  for (const bool paused : {false, true}) {
    const DaemonProcess daemon;
    CellClient client(daemon.port("grpc"));
    if (paused) {
      ASSERT_EQ(run_aprsim(daemon, {"pause"}).exit_code, 0);
    }
    const std::uint64_t before = client.snapshot().applied_ticket();
    TerminalProcess running(cli_command(daemon, {"run", "--time", "1000"}));
    client.wait_for(
        [&](const v1::Snapshot& now) { return now.applied_ticket() > before && !now.paused(); },
        "the run to begin");
    running.type("\x03");
    EXPECT_EQ(running.wait_for_exit(), -SIGINT) << running.output();
    const std::string state =
        paused ? "the cell is paused, as before, at" : "the cell continues as before";
    EXPECT_NE(running.output().find(state), std::string::npos) << running.output();
    EXPECT_EQ(client.snapshot().paused(), paused);
  }
}

}  // namespace
}  // namespace aprsim::test
