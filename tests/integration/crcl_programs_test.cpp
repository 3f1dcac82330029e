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

/// In what a program ends: done with its last command where `error` is empty.
struct Outcome {
  std::string error;
  std::string because;
};

const Outcome kToTheEnd{"",
                        "every pose is within reach; guards that find nothing let the move end"};
const Outcome kNothingToTouch{"required trigger not seen, limit 10",
                              "its guard requires a touch, and the cell is empty"};

// The elbow of the SIA20 is stretched at 910 mm from the shoulder to the wrist, which is 482 mm
// above the tool point here.
Outcome beyond_reach(const std::string& by_m) {
  return {"out of reach by " + by_m + " m: wrist at",
          "at X -300, Y 810 the arm is stretched before it is as low as the guarded move may go"};
}

const std::map<std::string, Outcome> kOutcomes = {
    {"fanucStackMoveBackRepeat3.xml", kToTheEnd},
    {"fanucStackMoveRepeat3.xml", kToTheEnd},
    {"fanucTestForceSensorProgram.xml", kToTheEnd},
    {"fanucTestForceSensorProgram2.xml", kToTheEnd},
    {"motomanStackMove.xml", kToTheEnd},
    {"motomanStackMoveBack.xml", beyond_reach("0.0006")},
    {"motomanStackMoveBack2.xml", beyond_reach("0.0006")},
    {"motomanStackMoveBackRepeat3.xml", beyond_reach("0.0074")},
    {"motomanStackMoveRepeat3.xml", kNothingToTouch},
    {"motomanTestForceSensorProgram.xml", kToTheEnd},
    {"motomanTestForceSensorProgram2.xml", kToTheEnd},
    {"motomanTestForceSensorProgram3.xml", kToTheEnd},
    {"motomanTestForceSensorProgram4.xml", kToTheEnd},
    {"simMotomanStackMove.xml", kNothingToTouch},
    {"simMotomanStackMove2.xml", kNothingToTouch},
    {"simMotomanStackMoveRepeat3.xml", kToTheEnd},
    {"simMotomanTestForceSensorProgram.xml", kToTheEnd},
    {"simMotomanTestForceSensorProgramSlow.xml", kToTheEnd},
};

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The status in which a program ends: in error, or done with its last command.
std::string outcome_of(CrclTextClient& client, const std::string& program) {
  client.raw(program);
  // Of each command.
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
  }
  throw std::runtime_error("the program does not end");
}

void run_programs(const std::string& robot, const std::string& prefixes) {
  const fs::path folder = fs::path(APRSIM_REFERENCE_DIR) / "aprs/data/crcl_programs";
  if (std::string(APRSIM_REFERENCE_DIR).empty()) {
    GTEST_SKIP() << "no reference material: APRSIM_REFERENCE_DIR is not set";
  }
  DaemonProcess daemon({"--scene", robot + "_only", "--speed", "max"});
  int run = 0;
  for (const auto& [file, expected] : kOutcomes) {
    if (prefixes.find(file[0]) == std::string::npos) continue;
    SCOPED_TRACE(file + ": " + expected.because);
    CrclTextClient client(daemon.port("crcl." + robot));
    const std::string status = outcome_of(client, read(folder / file));
    const std::string text = CrclTextClient::field(status, "StateDescription");
    const bool failed = CrclTextClient::field(status, "CommandState") == "CRCL_Error";
    EXPECT_EQ(failed, !expected.error.empty()) << text;
    EXPECT_NE(text.find(expected.error), std::string::npos) << text;
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
