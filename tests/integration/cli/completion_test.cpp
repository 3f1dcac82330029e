#include <algorithm>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/integration/cli/cli_commands.hpp"
#include "tests/support/terminal_process.hpp"

namespace aprsim::test {
namespace {

const std::string kShare = std::string(APRSIM_BIN_DIR) + "/../share";
const std::string kBash = kShare + "/bash-completion/completions/aprsim";
const std::string kZsh = kShare + "/zsh/site-functions";

/// The completions that bash offers for the last of these words.
std::vector<std::string> offers(const std::vector<std::string>& words) {
  std::vector<std::string> argv = {"bash", "-c",
                                   "source \"$0\"; COMP_WORDS=(\"$@\"); COMP_CWORD=$(($# - 1)); "
                                   "_aprsim; printf '%s\\n' \"${COMPREPLY[@]}\"",
                                   kBash};
  argv.insert(argv.end(), words.begin(), words.end());
  const auto result = run_process(argv);
  EXPECT_EQ(result.err, "");
  std::istringstream lines(result.out);
  std::vector<std::string> out;
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty()) out.push_back(line);
  }
  std::ranges::sort(out);
  return out;
}

using Words = std::vector<std::string>;

TEST(BashCompletion, CommandsOptionsAndValues) {
  EXPECT_EQ(offers({"aprsim", "cr"}), Words{"crcl"});
  EXPECT_EQ(offers({"aprsim", "conveyor", ""}), (Words{"map", "set", "status"}));
  EXPECT_EQ(offers({"aprsim", "crcl", "jog", "--ax"}), Words{"--axis"});
  EXPECT_EQ(offers({"aprsim", "crcl", "jog", "--axis", ""}), (Words{"x", "y", "z"}));
  EXPECT_EQ(offers({"aprsim", "crcl", "jog", "--robot", "m"}), Words{"motoman"});
  EXPECT_EQ(offers({"aprsim", "crcl", "jog", "--robot", "=", "m"}), Words{"motoman"});
  EXPECT_EQ(offers({"aprsim", "crcl", "gripper", "--robot", "fanuc", "o"}), Words{"open"});
  EXPECT_EQ(offers({"aprsim", "completion", ""}), (Words{"bash", "zsh"}));
  // Values that cannot be suggested.
  EXPECT_EQ(offers({"aprsim", "crcl", "jog", "--by", ""}), Words{});
}

TEST(BashCompletion, ProgramOptionsAreAllowedAnywhere) {
  EXPECT_EQ(offers({"aprsim", "--ho"}), Words{"--host"});
  EXPECT_EQ(offers({"aprsim", "--host", "cell", "dem"}), Words{"demo"});
  EXPECT_EQ(offers({"aprsim", "status", "--grpc"}), Words{"--grpc-port"});
  // The value of an option is no command.
  EXPECT_EQ(offers({"aprsim", "--host", "status", "watc"}), Words{"watch"});
}

TEST(BashCompletion, Files) {
  const TemporaryDirectory directory;
  const auto file = directory.write("program.xml", "");
  const auto part = file.substr(0, file.size() - 5);
  EXPECT_EQ(offers({"aprsim", "crcl", "run", part}), Words{file});
  EXPECT_EQ(offers({"aprsim", "--ports-file", part}), Words{file});
}

TEST(ZshCompletion, CommandsOptionsAndValues) {
  const TemporaryDirectory home;
  TerminalProcess zsh({"zsh", "-f", "-i"}, {"TERM=dumb", "HOME=" + home.path()});
  zsh.type("PS1='ready''> '; fpath=(" + kZsh + " $fpath); autoload -Uz compinit; compinit -u -D\n");
  zsh.wait_for("ready> ");
  const std::vector<std::pair<std::string, std::string>> typed = {
      {"aprsim cr", "aprsim crcl"},
      {"aprsim crcl jo", "aprsim crcl jog"},
      {"aprsim crcl jog --ax", "aprsim crcl jog --axis"},
      {"aprsim crcl jog --robot m", "aprsim crcl jog --robot motoman"},
      {"aprsim conveyor set --dir", "aprsim conveyor set --direction"},
      {"aprsim conveyor set --direction f", "aprsim conveyor set --direction forward"},
      {"aprsim --ho", "aprsim --host"},
      {"aprsim status --grpc", "aprsim status --grpc-port"},
      {"aprsim completion z", "aprsim completion zsh"},
  };
  for (const auto& [keys, line] : typed) {
    // The shell is asked what stands in the line, so that no echo is mistaken for it.
    zsh.type(keys + "\t");
    zsh.type("\x01line='\x05'; print -r -- \"is:$line:\"\n");
    zsh.wait_for("is:" + line + ":");
    zsh.wait_for("ready> ");
  }
}

TEST(Manual, MandocReportsNothing) {
  const auto lint =
      run_process({"mandoc", "-T", "lint", "-W", "warning", kShare + "/man/man1/aprsim.1"});
  EXPECT_EQ(lint.exit_code, 0);
  EXPECT_EQ(lint.out + lint.err, "");
}

TEST(Manual, ListsEveryCommandAndExitCode) {
  const auto shown = run_process({"mandoc", "-T", "ascii", kShare + "/man/man1/aprsim.1"}).out;
  std::string text;  // without the overstriking of bold and underlined characters
  for (const char c : shown) {
    if (c == '\b') {
      text.pop_back();
    } else {
      text += c;
    }
  }
  for (const char* part : {"crcl jog", "conveyor status", "--full-scale", "APRSIM_PORTS_FILE",
                           "NO_COLOR", "motor_current_a", "130", "(required)"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " in\n" << text;
  }
}

}  // namespace
}  // namespace aprsim::test
