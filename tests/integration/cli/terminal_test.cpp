#include <algorithm>
#include <csignal>

#include <gtest/gtest.h>

#include "tests/integration/cli/cli_commands.hpp"
#include "tests/support/terminal_process.hpp"

namespace aprsim::test {
namespace {

constexpr const char* kEscape = "\x1b[";

class Terminal : public testing::Test {
 protected:
  DaemonProcess daemon_;

  /// All that a command shows on a terminal.
  std::string shown(const std::vector<std::string>& arguments,
                    const std::vector<std::string>& environment) const {
    TerminalProcess process(cli_command(daemon_, arguments), environment);
    process.wait_for_exit();
    return process.output();
  }
};

TEST_F(Terminal, ColoursUnlessTheUserWantsNone) {
  const std::vector<std::string> terminal = {"TERM=xterm", "NO_COLOR"};
  EXPECT_NE(shown({"status"}, terminal).find("\x1b[1mcell\x1b[0m"), std::string::npos);
  EXPECT_NE(shown({"crcl", "status", "--robot", "fanuc"}, terminal).find(kEscape),
            std::string::npos);
  EXPECT_NE(shown({"load", "nothing"}, terminal).find("\x1b[1;31maprsim:\x1b[0m"),
            std::string::npos);
  for (const char* other : {"NO_COLOR=1", "TERM=dumb", "TERM"}) {
    auto environment = terminal;
    environment.emplace_back(other);
    if (std::string(other).starts_with("TERM")) environment.erase(environment.begin());
    if (std::string(other).starts_with("NO")) environment.erase(environment.begin() + 1);
    EXPECT_EQ(shown({"status"}, environment).find(kEscape), std::string::npos) << other;
    EXPECT_EQ(shown({"load", "nothing"}, environment).find(kEscape), std::string::npos) << other;
  }
  // No value is the same as none (no-color.org).
  EXPECT_NE(shown({"status"}, {"TERM=xterm", "NO_COLOR="}).find(kEscape), std::string::npos);
}

TEST_F(Terminal, NoColoursInPipesAndJson) {
  EXPECT_EQ(run_aprsim(daemon_, {"status"}).out.find(kEscape), std::string::npos);
  EXPECT_EQ(shown({"status", "--json"}, {"TERM=xterm", "NO_COLOR"}).find(kEscape),
            std::string::npos);
}

TEST_F(Terminal, WatchRedrawsInPlace) {
  const auto text = shown({"watch", "--count", "3", "--rate", "50"}, {"TERM=xterm", "NO_COLOR=1"});
  // From the second on, up to where the first began: as many lines as there are.
  std::size_t ups = 0;
  for (std::size_t at = 0; (at = text.find("A\r", at)) != std::string::npos; ++at) ++ups;
  EXPECT_EQ(ups, 2U) << text;
  const auto first_up = text.find("A\r");
  const auto lines = std::count(text.begin(), text.begin() + static_cast<long>(first_up), '\n');
  EXPECT_NE(text.find("\x1b[" + std::to_string(lines) + "A"), std::string::npos) << text;
  EXPECT_LT(lines, 24) << "more than fits";
}

TEST_F(Terminal, WatchInAPipeIsLines) {
  const auto result = run_aprsim(daemon_, {"watch", "--count", "3", "--rate", "50"});
  EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), 3);
  EXPECT_EQ(result.out.find(kEscape), std::string::npos);
}

TEST_F(Terminal, WatchingARobotRedrawsItsLine) {
  const auto text = shown({"crcl", "status", "--robot", "fanuc", "--watch", "--count", "4"},
                          {"TERM=xterm", "NO_COLOR=1"});
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4) << text;
  EXPECT_NE(text.find("\x1b[1A"), std::string::npos) << text;
}

}  // namespace
}  // namespace aprsim::test
