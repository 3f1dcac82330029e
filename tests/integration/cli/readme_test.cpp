#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <regex>
#include <thread>

#include <gtest/gtest.h>

#include "tests/integration/cli/cli_commands.hpp"
#include "tests/support/patience.hpp"
#include "tests/support/terminal_process.hpp"

namespace aprsim::test {
namespace {

namespace fs = std::filesystem;

/// README.md and the pages of docs, relative to the tree.
std::vector<std::string> documents() {
  std::vector<std::string> out{"README.md"};
  const fs::path root = APRSIM_SOURCE_DIR;
  for (const auto& entry : fs::directory_iterator(root / "docs")) {
    if (entry.path().extension() == ".md") out.push_back(fs::relative(entry, root).string());
  }
  std::ranges::sort(out);
  return out;
}

/// The commands of the client that a document shows, in its order: lines of shell blocks that begin
/// with "$ ", and code within a line that begins with "aprsim ".
std::vector<std::string> commands_of(const std::string& document) {
  std::ifstream in(std::string(APRSIM_SOURCE_DIR) + "/" + document);
  const std::regex line_form(R"(^    \$ (.*\baprsim .*)$)");
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
  return std::regex_search(command, std::regex(R"(aprsim (watch|events)|--watch)")) &&
         command.find("--count") == std::string::npos;
}

class Documents : public testing::TestWithParam<std::string> {};

TEST_P(Documents, ShowCommandsThatRunAsTheyStand) {
  const auto commands = commands_of(GetParam());
  if (commands.empty()) return;
  // A pace that the daemon holds: else its status is a fault.
  std::vector<std::string> arguments{"--speed", kPatience > 1 ? "0.5" : "2"};
  const std::string journal = "/tmp/run.journal";
  const bool records = std::ranges::any_of(
      commands, [&](const auto& command) { return command.find(journal) != std::string::npos; });
  if (records) arguments.insert(arguments.end(), {"--journal", journal});
  if (records) fs::remove(journal);
  DaemonProcess daemon(arguments);
  const auto deadline = std::chrono::steady_clock::now() + kPatience * std::chrono::seconds(60);
  while (records && (!fs::exists(journal) || fs::file_size(journal) == 0)) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline) << "the journal is not begun";
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  // The programs under test instead of installed ones, the ports of the daemon instead of the
  // default ones, from the folder of README.md.
  const std::string bin = APRSIM_BIN_DIR;
  const std::string prelude = std::string("cd '") + APRSIM_SOURCE_DIR +
                              "' && export APRSIM_PORTS_FILE='" + daemon.ports_file() +
                              "' PATH=\"" + bin + ":$PATH\" && set -o pipefail && ";
  for (const auto& command : commands) {
    TerminalProcess shell({"bash", "-c", prelude + command}, {"TERM=xterm", "NO_COLOR=1"});
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

INSTANTIATE_TEST_SUITE_P(, Documents, testing::ValuesIn(documents()),
                         [](const auto& test) { return fs::path(test.param).stem().string(); });

TEST(Readme, ShowsCommands) { EXPECT_GE(commands_of("README.md").size(), 8U); }

}  // namespace
}  // namespace aprsim::test
