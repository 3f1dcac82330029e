// The lab's recorded programs, each sent whole to its robot in the scene that counts joints and
// poses as they do, as fast as possible: each ends as protocols/CONTROLLERS.md states.

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <sstream>
#include <thread>

#include <gtest/gtest.h>

#include "tests/support/crcl_text_client.hpp"
#include "tests/support/daemon_process.hpp"

namespace aprsim::test {
namespace {

namespace fs = std::filesystem;

/// In what a program ends: done with its last command where `error` is empty.
struct Ending {
  std::string error;
  int command = -1;  ///< index of the one that fails
};

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The status in which a program ends: in error, or done with its last command.
std::string outcome_of(CrclTextClient& client, const std::string& program) {
  client.raw(program);
  // Time limit of each command.
  const auto limit = std::chrono::minutes(30);
  auto deadline = std::chrono::steady_clock::now() + limit;
  std::string before;
  while (std::chrono::steady_clock::now() < deadline) {
    std::string status = client.status();
    if (CrclTextClient::field(status, "CommandState") == "CRCL_Error") return status;
    const std::string index = CrclTextClient::field(status, "ProgramIndex");
    if (index != before) deadline = std::chrono::steady_clock::now() + limit;
    before = index;
    const std::string length = CrclTextClient::field(status, "ProgramLength");
    const bool last = !index.empty() && std::stoi(index) + 1 == std::stoi(length);
    if (last && CrclTextClient::field(status, "CommandState") == "CRCL_Done") return status;
    // The programs need the processor more than the polls do.
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  throw std::runtime_error("the program does not end");
}

/// The stated endings by program, from the table in protocols/CONTROLLERS.md:
/// | `NAME` | to the end | ... |   or   | `NAME` | command N: `TEXT` | ... |
std::map<std::string, Ending> stated_endings() {
  std::map<std::string, Ending> out;
  std::istringstream lines(read(fs::path(APRSIM_SOURCE_DIR) / "protocols/CONTROLLERS.md"));
  const std::regex done("\\| `(\\w+)` \\| to the end \\|.*");
  const std::regex fails("\\| `(\\w+)` \\| command (\\d+): `([^`]+)` \\|.*");
  for (std::string line; std::getline(lines, line);) {
    std::smatch found;
    if (std::regex_match(line, found, done)) out[found[1]] = {};
    if (std::regex_match(line, found, fails)) out[found[1]] = {found[3], std::stoi(found[2])};
  }
  return out;
}

void run_programs(const std::string& robot, const std::string& prefixes) {
  if (std::string(APRSIM_REFERENCE_DIR).empty()) {
    GTEST_SKIP() << "no reference material: APRSIM_REFERENCE_DIR is not set";
  }
  const fs::path folder = fs::path(APRSIM_REFERENCE_DIR) / "aprs/data/crcl_programs";
  const auto endings = stated_endings();
  int run = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().stem().string();
    SCOPED_TRACE(name);
    const auto stated = endings.find(name);
    ASSERT_NE(stated, endings.end());
    if (prefixes.find(name[0]) == std::string::npos) continue;
    DaemonProcess daemon({"--scene", "aprs_lab", "--speed", "max", "--no-web"});
    CrclTextClient client(daemon.port("crcl." + robot));
    const std::string status = outcome_of(client, read(entry.path()));
    const std::string text = CrclTextClient::field(status, "StateDescription");
    const bool failed = CrclTextClient::field(status, "CommandState") == "CRCL_Error";
    const Ending& ending = stated->second;
    const std::string index = CrclTextClient::field(status, "ProgramIndex");
    EXPECT_EQ(failed, !ending.error.empty()) << index << ": " << text;
    EXPECT_NE(text.find(ending.error), std::string::npos) << index << ": " << text;
    if (failed) {
      EXPECT_EQ(index, std::to_string(ending.command)) << text;
    }
    ++run;
  }
  EXPECT_GE(run, 4);
}

TEST(CrclPrograms, RunOnTheFanuc) { run_programs("fanuc", "f"); }
TEST(CrclPrograms, RunOnTheMotoman) { run_programs("motoman", "ms"); }

}  // namespace
}  // namespace aprsim::test
