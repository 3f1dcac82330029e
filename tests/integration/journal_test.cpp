// The daemon's journal: a run over sockets, ended by force, and run again from its files alone.

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/cell_client.hpp"
#include "tests/support/crcl_text_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::test {
namespace {

namespace fs = std::filesystem;

ProcessResult replay(std::vector<std::string> files) {
  files.insert(files.begin(), {std::string(APRSIM_BIN_DIR) + "/aprsimd", "--replay"});
  return run_process(files, std::chrono::seconds(250));
}

std::string to_joint(double degrees) {
  return "<ActuateJoint><JointNumber>1</JointNumber><JointPosition>" + std::to_string(degrees) +
         "</JointPosition><JointDetails "
         "xsi:type=\"JointSpeedAccelType\"><JointSpeed>40</JointSpeed>"
         "</JointDetails></ActuateJoint>";
}

/// Both robots swing and the belt runs, until so much time has passed.
void work(const DaemonProcess& daemon, std::uint64_t steps) {
  CellClient cell(daemon.port("grpc"));
  CrclTextClient fanuc(daemon.port("crcl.fanuc")), motoman(daemon.port("crcl.motoman"));
  fanuc.send("InitCanonType");
  motoman.send("InitCanonType");
  const std::uint64_t begin = cell.snapshot().step();
  for (double degrees = 15; cell.snapshot().step() < begin + steps; degrees = -degrees) {
    for (CrclTextClient* robot : {&fanuc, &motoman}) {
      robot->send("ActuateJointsType", to_joint(degrees));
      EXPECT_NE(CrclTextClient::field(robot->status(), "CommandState"), "CRCL_Error");
    }
  }
}

TEST(Journal, OfADaemonThatIsKilledIsRunAgainToTheSameStates) {
  const TemporaryDirectory directory;
  const std::string file = directory.path() + "/run.journal";
  {
    DaemonProcess daemon({"--journal", file, "--no-web", "--speed", "10"});
    work(daemon, 40'000);
    daemon.stop(SIGKILL);
  }
  const auto again = replay({file});
  EXPECT_EQ(again.exit_code, 0) << again.out << again.err;
  EXPECT_NE(again.out.find("all states are the same"), std::string::npos) << again.out;
  EXPECT_EQ(again.out.find("caution"), std::string::npos) << again.out;
  const auto count = [&](const std::string& what) {
    const auto end = again.out.find(' ' + what);
    const auto begin = again.out.rfind(' ', end - 1);
    return std::stoul(again.out.substr(begin + 1, end - begin - 1));
  };
  // At most a second of wall time is lost, and what a busy machine adds to it.
  EXPECT_GE(count("steps"), 10'000u) << again.out;
  EXPECT_GE(count("commands"), 20u) << again.out;
  EXPECT_GE(count("states"), 10u) << again.out;
}

TEST(Journal, GoesOnInFurtherFiles) {
  const TemporaryDirectory directory;
  {
    DaemonProcess daemon({"--journal", directory.path(), "--set", "journal.max_file_mb=1",
                          "--no-web", "--speed", "max"});
    work(daemon, 60'000);
    EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  }
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(directory.path())) {
    files.push_back(entry.path().string());
  }
  std::ranges::sort(files);
  ASSERT_FALSE(files.empty());
  const auto again = replay(files);
  EXPECT_EQ(again.exit_code, 0) << again.out << again.err;
  EXPECT_EQ(again.out.find("ends early"), std::string::npos) << again.out;
}

TEST(Journal, WhatIsNoneIsRefused) {
  const TemporaryDirectory directory;
  const std::string file = directory.path() + "/none.journal";
  auto refused = replay({file});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find(file), std::string::npos) << refused.err;
  std::ofstream(file) << "something else";
  refused = replay({file});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find(file), std::string::npos) << refused.err;
  const auto nowhere = run_process({std::string(APRSIM_BIN_DIR) + "/aprsimd", "--any-port",
                                    "--journal", directory.path() + "/no/run.journal"});
  EXPECT_EQ(nowhere.exit_code, 1);
  EXPECT_NE(nowhere.err.find("journal.place"), std::string::npos) << nowhere.err;
}

}  // namespace
}  // namespace aprsim::test
