// The lab's recorded programs, each sent whole to its robot alone in an empty cell, as fast as
// possible: to the end, or into the error that the robot's limits demand.

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include <gtest/gtest.h>

#include "tests/support/crcl_text_client.hpp"
#include "tests/support/daemon_process.hpp"

namespace aprsim::test {
namespace {

namespace fs = std::filesystem;

/// What each file ends in: nothing = its last command is done, else what its error says.
const std::map<std::string, std::string> kOutcomes = {
    {"fanucStackMoveBackRepeat3.xml", ""},
    {"fanucStackMoveRepeat3.xml", ""},
    {"fanucTestForceSensorProgram.xml", ""},
    {"fanucTestForceSensorProgram2.xml", ""},
    {"motomanStackMove.xml", ""},
    {"motomanStackMoveBack.xml", ""},
    {"motomanStackMoveBack2.xml", ""},
    {"motomanStackMoveBackRepeat3.xml", ""},
    {"motomanStackMoveRepeat3.xml", ""},
    {"motomanTestForceSensorProgram.xml", ""},
    {"motomanTestForceSensorProgram2.xml", ""},
    {"motomanTestForceSensorProgram3.xml", ""},
    {"motomanTestForceSensorProgram4.xml", ""},
    {"simMotomanStackMove.xml", ""},
    {"simMotomanStackMove2.xml", ""},
    {"simMotomanStackMoveRepeat3.xml", ""},
    {"simMotomanTestForceSensorProgram.xml", ""},
    {"simMotomanTestForceSensorProgramSlow.xml", ""},
};

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The status in which a program ends: in error, or done with its last command.
std::string outcome_of(CrclTextClient& client, const std::string& program) {
  client.raw(program);
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (std::chrono::steady_clock::now() < deadline) {
    std::string status = client.status();
    if (CrclTextClient::field(status, "CommandState") == "CRCL_Error") return status;
    const std::string index = CrclTextClient::field(status, "ProgramIndex");
    const std::string length = CrclTextClient::field(status, "ProgramLength");
    const bool last = !index.empty() && std::stoi(index) + 1 == std::stoi(length);
    if (last && CrclTextClient::field(status, "CommandState") == "CRCL_Done") return status;
  }
  throw std::runtime_error("the program does not end");
}

void run_programs(const std::string& robot, const std::string& prefixes) {
  const fs::path folder = fs::path(APRSIM_REFERENCE_DIR) / "aprs/data/crcl_programs";
  if (std::string(APRSIM_REFERENCE_DIR).empty() || !fs::exists(folder)) {
    GTEST_SKIP() << "no reference material: APRSIM_REFERENCE_DIR is not set";
  }
  DaemonProcess daemon({"--scene", robot + "_only", "--speed", "max"});
  int run = 0;
  for (const auto& [file, expected] : kOutcomes) {
    if (prefixes.find(file[0]) == std::string::npos) continue;
    SCOPED_TRACE(file);
    CrclTextClient client(daemon.port("crcl." + robot));
    const std::string status = outcome_of(client, read(folder / file));
    const std::string text = CrclTextClient::field(status, "StateDescription");
    const bool failed = CrclTextClient::field(status, "CommandState") == "CRCL_Error";
    EXPECT_EQ(failed, !expected.empty()) << text;
    EXPECT_NE(text.find(expected), std::string::npos) << text;
    ++run;
  }
  for (const auto& entry : fs::directory_iterator(folder)) {
    EXPECT_TRUE(kOutcomes.contains(entry.path().filename().string())) << entry.path();
  }
  EXPECT_GT(run, 0);
}

TEST(CrclPrograms, OfTheFanuc) { run_programs("fanuc", "f"); }
TEST(CrclPrograms, OfTheMotoman) { run_programs("motoman", "ms"); }

}  // namespace
}  // namespace aprsim::test
