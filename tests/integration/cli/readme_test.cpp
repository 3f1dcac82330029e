#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <thread>

#include <gtest/gtest.h>

#include "tests/integration/cli/cli_commands.hpp"
#include "tests/support/patience.hpp"
#include "tests/support/temporary_directory.hpp"
#include "tests/support/terminal_process.hpp"

namespace aprsim::test {
namespace {

namespace fs = std::filesystem;

/// Parts of a document that run, in its order.
struct Document {
  /// Commands for bash: lines of indented blocks that begin with "$ ", with the lines that they
  /// continue on, and code within a line that begins with "aprsim "; fenced Python is one as well.
  std::vector<std::string> commands;
  /// Fenced blocks whose first line is a comment with a file's name, by that name.
  std::map<std::string, std::string> files;
  /// Arguments of the first indented line that starts a daemon.
  std::vector<std::string> daemon;
};

/// README.md, the pages of docs and the package's page, relative to the tree.
std::vector<std::string> documents() {
  std::vector<std::string> out{"README.md", "clients/python/README.md"};
  const fs::path root = APRSIM_SOURCE_DIR;
  for (const auto& entry : fs::directory_iterator(root / "docs")) {
    if (entry.path().extension() == ".md") out.push_back(fs::relative(entry, root).string());
  }
  std::ranges::sort(out);
  return out;
}

std::string name_of(const std::string& document) {
  std::string name = fs::path(document).replace_extension().string();
  std::ranges::replace_if(
      name, [](char c) { return std::isalnum(c) == 0; }, '_');
  return name;
}

/// Adds a fenced block: a file, or Python that runs as it stands.
void add_block(const std::string& language, const std::string& text, Document& out) {
  std::smatch found;
  const std::string first = text.substr(0, text.find('\n'));
  if (std::regex_match(first, found, std::regex(R"(# (\w+\.(?:yaml|py)))"))) {
    out.files[found[1]] = text;
  } else if (language == "python") {
    out.commands.push_back("/usr/bin/python3 - <<'END_OF_SNIPPET'\n" + text + "END_OF_SNIPPET");
  }
}

void add_line(const std::string& line, Document& out) {
  static const std::regex kCommand(R"(^    \$ (.*)$)"), kCode("`(aprsim [^`]*)`"),
      kDaemon(R"(^    (?:aprsimd|server/run --) ([^#]*?)\s*(?:#.*)?$)");
  std::smatch found;
  if (std::regex_match(line, found, kCommand)) {
    out.commands.push_back(found[1]);
  } else if (out.daemon.empty() && std::regex_match(line, found, kDaemon)) {
    std::istringstream words(found[1]);
    for (std::string word; words >> word;) out.daemon.push_back(word);
  } else {
    for (std::sregex_iterator code(line.begin(), line.end(), kCode), end; code != end; ++code) {
      out.commands.push_back((*code)[1]);
    }
  }
}

Document read_document(const std::string& name) {
  std::ifstream in(std::string(APRSIM_SOURCE_DIR) + "/" + name);
  Document out;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("```")) {
      const std::string language = line.substr(3);
      std::string text;
      while (std::getline(in, line) && line != "```") text += line + "\n";
      add_block(language, text, out);
    } else if (!out.commands.empty() && out.commands.back().ends_with('\\')) {
      out.commands.back() += "\n" + line;
    } else {
      add_line(line, out);
    }
  }
  return out;
}

/// Indented lines that begin with a program and without "$ ": they do not run as they stand.
std::vector<std::string> other_commands(const std::string& name) {
  static const std::regex kProgram(
      R"(^    ((?:server|tests|docs|clients|docker|build)/\S.*|(?:aprsimd?|sbatch|scontrol|kubectl|)"
      R"(python3|pip|tcpdump|curl|openssl|docker|apptainer|systemctl|mbpoll) .*)$)");
  std::ifstream in(std::string(APRSIM_SOURCE_DIR) + "/" + name);
  std::vector<std::string> out;
  bool fenced = false;
  std::smatch found;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("```")) fenced = !fenced;
    if (!fenced && std::regex_match(line, found, kProgram)) out.push_back(found[1]);
  }
  return out;
}

/// A command that does not run as it stands, by its beginning, and a test that runs it.
struct TestedElsewhere {
  const char* command;
  const char* file;  ///< of the test
  const char* text;  ///< of that file
};

constexpr TestedElsewhere kTestedElsewhere[] = {
    {"server/run", "tests/fresh", "enter server/run"},
    {"tests/run", "tests/fresh", "enter tests/run"},
    {"server/lab", "tests/integration/laboratory/test_lab.py", "\"server\" / \"lab\""},
    {"aprsimd --scene workbench.yaml", "tests/integration/cli/readme_test.cpp", "kDaemon"},
    {"build/release/bin/aprsimd --scene clients/devices",
     "tests/integration/python/test_devices.py", "\"weighing.yaml\""},
    {"clients/kitting/kitting", "tests/integration/kitting/test_cell.py", "whole jobs"},
    {"aprsim device set", "tests/integration/python/test_devices.py",
     "\"device\", \"set\", \"pusher\""},
    {"aprsim --ca ca.pem --certificate me.pem --key me.key conform modbus",
     "tests/integration/access/test_modbus_security.py", "--secure"},
    {"aprsim --host cell --ca ca.pem --certificate me.pem --key me.key conveyor",
     "tests/integration/access/test_modbus_security.py", "\"status\", \"--secure\""},
    {"aprsim modbus map", "tests/integration/python/test_modbus_servers.py",
     "\"modbus\", \"map\", \"line\""},
    {"aprsim camera fit", "tests/integration/python/test_camera_fit.py", "\"camera\", \"fit\""},
    {"aprsim calibrate", "tests/integration/python/test_calibration.py", "\"calibrate\""},
    {"aprsim compare", "tests/integration/python/test_calibration.py", "\"compare\""},
    {"build/release/bin/aprsim-ros2", "tests/ros2/publishing_test.cpp", "aprsim-ros2"},
    {"python3 -m venv", "tests/integration/python/test_install.py", "python3 -m venv"},
    {"python3 -m aprsim.datasets", "tests/integration/python/test_datasets.py",
     "python3 -m aprsim.datasets "},
    {"python3 -m aprsim.real", "tests/integration/python/test_real.py", "python3 -m aprsim.real "},
    {"python3 clients/python/examples/learn.py", "tests/integration/python/test_learn.py",
     "\"examples\" / \"learn.py\""},
    {"python3 -m clients.vision", "tests/integration/vision/test_wires.py", "--write-ports="},
    {"build/venv/bin/pip", "tests/integration/python/test_install.py", "build/venv/bin/pip"},
    {"docker/debian/build", "tests/package/debian", "docker/debian/build \""},
    {"docker/debian/repository", "tests/package/debian", "docker/debian/repository \""},
    {"tests/soak/run", "tests/soak/CMakeLists.txt", "/run --minutes"},
    {"sbatch", "tests/cluster/test_slurm.py", "docker/slurm/batch.sbatch"},
    {"aprsim merge", "tests/integration/cli/batch_test.cpp", "\"merge\""},
    {"aprsim trace diff", "tests/integration/cli/exit_codes_test.cpp", "\"trace diff\""},
    {"aprsim trace import", "tests/integration/cli/exit_codes_test.cpp", "\"trace import\""},
};

/// Whether it shows something until it is interrupted.
bool goes_on(const std::string& command) {
  return std::regex_search(command, std::regex(R"(aprsim (watch|events)|--watch)")) &&
         command.find("--count") == std::string::npos &&
         command.find("--past") == std::string::npos;
}

/// With the daemon's ports in place of the default ones.
std::string with_ports(const std::string& command, const DaemonProcess& daemon) {
  static const std::map<std::string, std::string> kEndpoints = {
      {"64444", "crcl.fanuc"},  {"64445", "crcl.motoman"},  {"1502", "modbus"},
      {"4000", "vision.fanuc"}, {"4001", "vision.motoman"}, {"50051", "grpc"},
      {"8080", "web"}};
  static const std::regex kPort(R"(\b(64444|64445|1502|4000|4001|50051|8080)\b)");
  std::string out;
  std::size_t at = 0;
  for (std::sregex_iterator port(command.begin(), command.end(), kPort), end; port != end; ++port) {
    const auto bound = daemon.ports().find(kEndpoints.at((*port)[1]));
    const auto begin = static_cast<std::size_t>(port->position());
    out += command.substr(at, begin - at);
    out += bound == daemon.ports().end() ? port->str() : std::to_string(bound->second);
    at = begin + port->str().size();
  }
  return out + command.substr(at);
}

class Documents : public testing::TestWithParam<std::string> {
 protected:
  /// The document's daemon, at a pace that it holds: else its status is a fault.
  std::vector<std::string> daemon_arguments(const Document& document) const {
    std::vector<std::string> out{"--speed", kPatience > 1 ? "0.5" : "2"};
    for (const std::string& word : document.daemon) {
      const fs::path file = fs::path(folder_.path()) / word;
      out.push_back(document.files.contains(word) ? file.string() : word);
    }
    return out;
  }

  /// Waits until the daemon has begun the journal that it is started with.
  static void await_journal(const std::vector<std::string>& arguments) {
    const auto option = std::ranges::find(arguments, "--journal");
    if (option == arguments.end()) return;
    const fs::path journal = *std::next(option);
    const auto deadline = std::chrono::steady_clock::now() + kPatience * std::chrono::seconds(60);
    while (!fs::exists(journal) || fs::file_size(journal) == 0) {
      ASSERT_LT(std::chrono::steady_clock::now(), deadline) << "the journal is not begun";
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }

  /// The programs under test instead of installed ones, from the tree's root, or from the folder
  /// with the document's files.
  [[nodiscard]] std::string prelude(const DaemonProcess& daemon, bool has_files) const {
    const std::string root = APRSIM_SOURCE_DIR;
    return "cd '" + (has_files ? folder_.path() : root) + "' && export APRSIM_PORTS_FILE='" +
           daemon.ports_file() + "' PYTHONPATH='" + root + "/clients/python' PATH=\"" +
           APRSIM_BIN_DIR + ":/usr/bin:$PATH\" && set -o pipefail && ";
  }

  static void run(const std::string& command, const std::string& prelude) {
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

  TemporaryDirectory folder_;
};

TEST_P(Documents, ShowCommandsThatRunAsTheyStand) {
  const Document document = read_document(GetParam());
  if (document.commands.empty()) return;
  for (const auto& [name, text] : document.files) folder_.write(name, text);
  const auto arguments = daemon_arguments(document);
  if (const auto journal = std::ranges::find(arguments, "--journal"); journal != arguments.end()) {
    fs::remove(*std::next(journal));
  }
  DaemonProcess daemon(arguments);
  ASSERT_NO_FATAL_FAILURE(await_journal(arguments));
  for (const auto& command : document.commands) {
    run(with_ports(command, daemon), prelude(daemon, !document.files.empty()));
  }
}

INSTANTIATE_TEST_SUITE_P(, Documents, testing::ValuesIn(documents()),
                         [](const auto& test) { return name_of(test.param); });

TEST(Readme, NamesATestForEachCommandThatDoesNotRunAsItStands) {
  std::vector<bool> used(std::size(kTestedElsewhere));
  for (const auto& document : documents()) {
    for (const auto& command : other_commands(document)) {
      const auto* const known = std::ranges::find_if(
          kTestedElsewhere, [&](const auto& one) { return command.starts_with(one.command); });
      ASSERT_NE(known, std::end(kTestedElsewhere)) << document << ": " << command;
      used[static_cast<std::size_t>(known - kTestedElsewhere)] = true;
      std::ifstream in(std::string(APRSIM_SOURCE_DIR) + "/" + known->file);
      const std::string text{std::istreambuf_iterator<char>(in), {}};
      EXPECT_NE(text.find(known->text), std::string::npos) << known->file << ": " << known->text;
    }
  }
  EXPECT_EQ(std::ranges::find(used, false) - used.begin(), std::ssize(used)) << "an unused entry";
}

TEST(Readme, ShowsCommands) {
  EXPECT_GE(read_document("README.md").commands.size(), 8U);
  const Document tutorial = read_document("docs/tutorial.md");
  EXPECT_EQ(tutorial.files.size(), 3U);
  EXPECT_GE(tutorial.commands.size(), 4U);
  EXPECT_FALSE(tutorial.daemon.empty());
}

}  // namespace
}  // namespace aprsim::test
