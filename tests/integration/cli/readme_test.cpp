#include <csignal>
#include <fstream>
#include <regex>

#include <gtest/gtest.h>

#include "tests/integration/cli/cli_commands.hpp"
#include "tests/support/patience.hpp"
#include "tests/support/terminal_process.hpp"

namespace aprsim::test {
namespace {

/// The commands of the client that README.md shows, in its order: lines of shell blocks that begin
/// with "$ ", and code within a line that begins with "aprsim ".
std::vector<std::string> commands_of_readme() {
  std::ifstream in(std::string(APRSIM_SOURCE_DIR) + "/README.md");
  const std::regex line_form(R"(^    \$ (.*build/release/bin/aprsim .*)$)");
  const std::regex code_form("`(aprsim [^`]*)`");
  std::vector<std::string> out;
  for (std::string line; std::getline(in, line);) {
    std::smatch found;
    if (std::regex_match(line, found, line_form)) {
      out.push_back(found[1]);
      continue;
    }
    for (std::sregex_iterator code(line.begin(), line.end(), code_form), end; code != end; ++code) {
      out.push_back((*code)[1]);
    }
  }
  return out;
}

/// Whether it shows something until it is interrupted.
bool goes_on(const std::string& command) {
  return std::regex_search(command, std::regex(R"(aprsim watch|--watch)")) &&
         command.find("--count") == std::string::npos;
}

TEST(Readme, EveryCommandRunsAsItStands) {
  // A pace that it holds: else its status is a fault.
  DaemonProcess daemon(
      {"--speed", kPatience > 1 ? "0.5" : "2", "--journal", "/tmp/run.journal"});  // as it says
  const auto commands = commands_of_readme();
  ASSERT_GE(commands.size(), 20U) << "the form of README.md has changed";
  // The programs under test in the place of those that README.md builds, its daemon's ports in that
  // of the default ones, from the folder that README.md stands in.
  const std::string bin = APRSIM_BIN_DIR;
  const std::string prelude = std::string("cd '") + APRSIM_SOURCE_DIR +
                              "' && export APRSIM_PORTS_FILE='" + daemon.ports_file() +
                              "' PATH=\"" + bin + ":$PATH\" && set -o pipefail && ";
  for (const auto& command : commands) {
    const std::string text =
        prelude + std::regex_replace(command, std::regex("build/release/bin/aprsim"), "aprsim");
    TerminalProcess shell({"bash", "-c", text}, {"TERM=xterm", "NO_COLOR=1"});
    if (goes_on(command)) {
      shell.wait_for("\n", TerminalProcess::Seconds(30));
      shell.type("\x03");
      EXPECT_EQ(shell.wait_for_exit(), -SIGINT) << command << "\n" << shell.output();
    } else {
      EXPECT_EQ(shell.wait_for_exit(TerminalProcess::Seconds(900)), 0) << command << "\n"
                                                                       << shell.output();
    }
  }
}

}  // namespace
}  // namespace aprsim::test
