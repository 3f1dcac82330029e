// The daemon's journal: a run over sockets, ended by force, and run again from its files alone.

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "proto/journal/journal_reader.hpp"
#include "server/journal/replay.hpp"
#include "tests/support/cell_client.hpp"
#include "tests/support/crcl_text_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/patience.hpp"
#include "tests/support/small_disk.hpp"
#include "tests/support/tcp_socket.hpp"
#include "tests/support/temporary_directory.hpp"
#include "tests/support/vision_client.hpp"

namespace aprsim::test {
namespace {

namespace fs = std::filesystem;

ProcessResult replay(std::vector<std::string> files) {
  files.insert(files.begin(), {std::string(APRSIM_BIN_DIR) + "/aprsimd", "--replay"});
  return run_process(files, std::chrono::seconds(1800));
}

std::string to_joint(double degrees) {
  return "<ActuateJoint><JointNumber>1</JointNumber><JointPosition>" + std::to_string(degrees) +
         "</JointPosition><JointDetails "
         "xsi:type=\"JointSpeedAccelType\"><JointSpeed>40</JointSpeed>"
         "</JointDetails></ActuateJoint>";
}

/// How much, from the environment.
std::uint64_t how_many(const char* variable, std::uint64_t otherwise) {
  const char* text = std::getenv(variable);
  return text == nullptr ? otherwise : std::stoull(text);
}

/// Writes one holding register of the belt and waits for the answer.
void write_register(TcpSocket& socket, int address, int value) {
  const auto high = [](int number) { return static_cast<char>(number >> 8); };
  const auto low = [](int number) { return static_cast<char>(number & 0xFF); };
  std::string request("\0\1\0\0\0\6\1\6", 8);
  request += {high(address), low(address), high(value), low(value)};
  ASSERT_TRUE(socket.send(request));
  const auto deadline = TcpSocket::Clock::now() + std::chrono::seconds(30);
  for (std::size_t got = 0; got < request.size();) got += socket.receive(deadline).size();
}

/// Both robots swing and grip, the belt runs to and fro and the cameras are read, all over sockets,
/// until so many steps have been taken.
void work(const DaemonProcess& daemon, std::uint64_t steps) {
  CellClient cell(daemon.port("grpc"));
  CrclTextClient fanuc(daemon.port("crcl.fanuc")), motoman(daemon.port("crcl.motoman"));
  TcpSocket belt(daemon.port("modbus"));
  VisionClient camera(daemon.port("vision.fanuc"));
  fanuc.send("InitCanonType");
  motoman.send("InitCanonType");
  write_register(belt, 0x8002, 10'000);  // 0.1 m/s
  write_register(belt, 0x8000, 1);
  const std::uint64_t begin = cell.snapshot().step();
  for (double degrees = 15; cell.snapshot().step() < begin + steps; degrees = -degrees) {
    for (CrclTextClient* robot : {&fanuc, &motoman}) {
      robot->send("ActuateJointsType", to_joint(degrees));
      EXPECT_NE(CrclTextClient::field(robot->status(), "CommandState"), "CRCL_Error");
      robot->send("SetEndEffectorType",
                  degrees > 0 ? "<Setting>1</Setting>" : "<Setting>0</Setting>");
      robot->status();
    }
    write_register(belt, 0x8001, degrees > 0 ? 1 : 0);
    camera.take();
  }
}

std::vector<v1::JournalRecord> records_of(journal::JournalReader& reader) {
  std::vector<v1::JournalRecord> all;
  for (v1::JournalRecord record; reader.next(record);) all.push_back(record);
  return all;
}

/// Runs what follows the checkpoint, up to the one behind the next.
server::journal::ReplayResult from_checkpoint(const v1::JournalHeader& header,
                                              const std::shared_ptr<const scene::Scene>& scene,
                                              const std::vector<v1::JournalRecord>& all,
                                              std::size_t checkpoint) {
  server::journal::Replay replay(header, scene);
  int passed = 0;
  for (std::size_t i = checkpoint; i < all.size() && passed < 3; ++i) {
    passed += all[i].has_checkpoint() ? 1 : 0;
    const auto goes_on = replay.take(all[i]);
    EXPECT_TRUE(goes_on) << goes_on.error().message;
    if (!goes_on || !*goes_on) break;
  }
  return replay.result();
}

// APRSIM_JOURNAL_STEPS makes it longer: 600000 are ten simulated minutes. APRSIM_JOURNAL_PROGRAMS
// names daemons that were built otherwise, which run it again, too.
TEST(Journal, OfADaemonThatIsKilledIsRunAgainToTheSameStates) {
  const TemporaryDirectory directory;
  const std::string file = directory.path() + "/run.journal";
  const std::uint64_t steps = how_many("APRSIM_JOURNAL_STEPS", 28'000);
  {
    DaemonProcess daemon(
        {"--journal", file, "--no-web", "--speed", "10", "--set", "journal.max_file_mb=1000"});
    work(daemon, steps);
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
  EXPECT_GE(count("steps"), steps / 4) << again.out;
  EXPECT_GE(count("commands"), 20u) << again.out;
  EXPECT_GE(count("states"), 10u) << again.out;

  // And from every checkpoint.
  auto reader = journal::JournalReader::open(file);
  ASSERT_TRUE(reader);
  const auto all = records_of(*reader);
  auto read = server::journal::scene_of(reader->header(), directory.path());
  ASSERT_TRUE(read) << read.error().message;
  const auto scene = std::make_shared<const scene::Scene>(std::move(*read));
  int checkpoints = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_FALSE(all[i].has_gap());
    if (!all[i].has_checkpoint()) continue;
    ++checkpoints;
    const auto result = from_checkpoint(reader->header(), scene, all, i);
    EXPECT_FALSE(result.difference)
        << "from step " << all[i].checkpoint().time().step() << ": " << result.difference->what;
  }
  EXPECT_GE(checkpoints, 2);
  const char* programs = std::getenv("APRSIM_JOURNAL_PROGRAMS");
  std::istringstream words(programs == nullptr ? "" : programs);
  for (std::string program; words >> program;) {
    const auto there = run_process({program, "--replay", file}, std::chrono::hours(1));
    EXPECT_EQ(there.exit_code, 0) << program << there.out << there.err;
    std::printf("%s: %s", program.c_str(), there.out.c_str());
  }
  std::printf("%d checkpoints, %ju bytes\n", checkpoints,
              static_cast<std::uintmax_t>(fs::file_size(file)));
}

// APRSIM_JOURNAL_KILLS makes it more thorough.
TEST(Journal, OfADaemonThatIsKilledAnyTimeLacksAMomentAtMost) {
  using std::chrono::system_clock;
  const std::uint64_t kills = how_many("APRSIM_JOURNAL_KILLS", 3);
  std::mt19937 random(std::random_device{}());
  std::chrono::duration<double> worst{0};
  for (std::uint64_t kill = 0; kill < kills; ++kill) {
    const TemporaryDirectory directory;
    const std::string file = directory.path() + "/run.journal";
    DaemonProcess daemon({"--journal", file, "--no-web", "--speed", "10"});
    // Records without a pause: a robot is asked all the time.
    CrclTextClient fanuc(daemon.port("crcl.fanuc"));
    const auto end = system_clock::now() + std::chrono::milliseconds(600 + random() % 2000);
    while (system_clock::now() < end) fanuc.status();
    const auto killed = system_clock::now();
    daemon.stop(SIGKILL);
    auto reader = journal::JournalReader::open(file);
    ASSERT_TRUE(reader) << reader.error().message;
    const auto all = records_of(*reader);
    ASSERT_FALSE(all.empty());
    EXPECT_EQ(reader->damage().find("damaged"), std::string::npos) << reader->damage();
    const auto& wall = all.back().wall_time();
    const auto last = system_clock::time_point(std::chrono::duration_cast<system_clock::duration>(
        std::chrono::seconds(wall.seconds()) + std::chrono::nanoseconds(wall.nanos())));
    worst = std::max<std::chrono::duration<double>>(worst, killed - last);
    EXPECT_EQ(replay({file}).exit_code, 0);
  }
  std::printf("at most %.3f s lost in %ju kills\n", worst.count(),
              static_cast<std::uintmax_t>(kills));
  // A second, and what a busy machine adds to it.
  EXPECT_LT(worst.count(), 2.0 * kPatience);
}

TEST(Journal, OfADiskThatRunsFullHasItsGapAndTheCellGoesOn) {
  const TemporaryDirectory directory;
  const std::string path = directory.path() + "/small";
  const SmallDisk small(path, "4m");
  if (!small.mounted()) GTEST_SKIP() << "a file system of 4 MB needs root";
  const std::string file = path + "/run.journal", filler = path + "/filler";
  std::ofstream(filler, std::ios::binary) << std::string((std::size_t{4} << 20) - 300'000, 'x');
  DaemonProcess daemon({"--journal", file, "--no-web", "--speed", "max"});
  CellClient cell(daemon.port("grpc"));
  CrclTextClient fanuc(daemon.port("crcl.fanuc"));
  fanuc.send("InitCanonType");
  const auto until = [&](const std::string& what, const auto& condition) {
    EXPECT_TRUE(eventually(
        [&] {
          fanuc.status();
          return condition();
        },
        std::chrono::seconds(60)))
        << what << daemon.log();
  };
  until("a full disk", [&] { return daemon.log().find("No space left") != std::string::npos; });
  const std::uint64_t full = cell.snapshot().step();
  until("further steps", [&] { return cell.snapshot().step() > full + 20'000; });
  fs::remove(filler);
  until("a further file", [&] { return fs::exists(file + ".2"); });
  const std::uint64_t again = cell.snapshot().step();
  until("more of it", [&] { return cell.snapshot().step() > again + 20'000; });
  EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  const auto both = replay({file, file + ".2"});
  EXPECT_EQ(both.exit_code, 0) << both.out << both.err;
  EXPECT_NE(both.out.find("all states are the same"), std::string::npos) << both.out;
}

TEST(Journal, IntoAPipeThatStallsHoldsNobodyUp) {
  const TemporaryDirectory directory;
  const std::string pipe = directory.path() + "/pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int stalled = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);  // opened, and never read
  ASSERT_GE(stalled, 0);
  DaemonProcess daemon({"--journal", pipe, "--no-web", "--speed", "max"});
  CellClient cell(daemon.port("grpc"));
  CrclTextClient fanuc(daemon.port("crcl.fanuc"));
  // More than the pipe takes, many times over.
  EXPECT_TRUE(eventually(
      [&] {
        fanuc.status();
        return cell.snapshot().step() > 60'000;
      },
      std::chrono::seconds(60)));
  EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  ::close(stalled);
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
