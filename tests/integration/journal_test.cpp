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
#include <stdexcept>
#include <string>
#include <string_view>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "proto/journal/journal_reader.hpp"
#include "server/journal/recorded_scenes.hpp"
#include "server/replay/replay.hpp"
#include "tests/support/cell_client.hpp"
#include "tests/support/crcl_text_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/patience.hpp"
#include "tests/support/small_disk.hpp"
#include "tests/support/tcp_socket.hpp"
#include "tests/support/temporary_directory.hpp"
#include "tests/support/vision_client.hpp"
#include "world/cell/state_bytes.hpp"

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

/// Random text, which compresses by at most a quarter.
std::string noise(std::size_t characters, std::mt19937& random) {
  static constexpr std::string_view kLetters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+-";
  std::string text(characters, ' ');
  for (char& letter : text) letter = kLetters[random() % kLetters.size()];
  return text;
}

/// The value of a metric, as the daemon's web port gives it.
std::uint64_t metric(const DaemonProcess& daemon, const std::string& name) {
  TcpSocket socket(daemon.port("web"));
  socket.send("GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  const auto deadline = TcpSocket::Clock::now() + std::chrono::seconds(30);
  std::string page;
  for (std::string some; !(some = socket.receive(deadline)).empty();) page += some;
  const auto at = page.find('\n' + name + ' ');
  if (at == std::string::npos) throw std::runtime_error("no metric " + name + " in " + page);
  return std::stoull(page.substr(at + name.size() + 2));
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
/// until it is enough.
void work(const DaemonProcess& daemon, const std::function<bool(CellClient&)>& is_enough) {
  CellClient cell(daemon.port("grpc"));
  CrclTextClient fanuc(daemon.port("crcl.fanuc")), motoman(daemon.port("crcl.motoman"));
  TcpSocket belt(daemon.port("modbus"));
  VisionClient camera(daemon.port("vision.fanuc"));
  fanuc.send("InitCanonType");
  motoman.send("InitCanonType");
  write_register(belt, 0x8002, 10'000);  // 0.1 m/s
  write_register(belt, 0x8000, 1);
  for (double degrees = 15; !is_enough(cell); degrees = -degrees) {
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

/// The same until so many steps have been taken.
void work(const DaemonProcess& daemon, std::uint64_t steps) {
  std::optional<std::uint64_t> end;
  work(daemon, [&](CellClient& cell) {
    const std::uint64_t step = cell.snapshot().step();
    if (!end) end = step + steps;
    return step >= *end;
  });
}

std::vector<v1::JournalRecord> records_of(journal::JournalReader& reader) {
  std::vector<v1::JournalRecord> all;
  for (v1::JournalRecord record; reader.next(record);) all.push_back(record);
  return all;
}

/// Numbers of the records with checkpoints.
std::vector<std::size_t> checkpoints_of(const std::vector<v1::JournalRecord>& all) {
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].has_checkpoint()) numbers.push_back(i);
  }
  return numbers;
}

/// Every byte of a state that decides what follows: who only runs it again watches no events.
std::string bytes_of(world::WorldState state) {
  state.apart.clear();
  return world::to_bytes(state);
}

/// Runs the records from a checkpoint to the last one; whatever a checkpoint on the way has, its
/// hash and every byte of its state, must come about again.
void expect_same_from(const v1::JournalHeader& header,
                      const std::shared_ptr<const scene::Scene>& scene,
                      const std::vector<v1::JournalRecord>& all, std::size_t first,
                      std::size_t last) {
  server::journal::Replay replay(header, scene);
  server::journal::RecordedScenes scenes(scene);
  for (std::size_t i = first; i <= last; ++i) {
    const auto goes_on = replay.process(all[i]);
    ASSERT_TRUE(goes_on) << goes_on.error().message;
    if (!*goes_on) break;
    if (!all[i].has_checkpoint()) continue;
    const auto recorded = scenes.state_of(all[i].checkpoint());
    ASSERT_TRUE(recorded) << recorded.error().message;
    ASSERT_TRUE(bytes_of(replay.world().save()) == bytes_of(*recorded))
        << "from record " << first << ": other bytes at step " << all[i].checkpoint().time().step();
  }
  EXPECT_FALSE(replay.result().difference)
      << "from record " << first << ": " << replay.result().difference->text;
}

// APRSIM_JOURNAL_STEPS makes it longer: 600000 are ten simulated minutes. APRSIM_JOURNAL_PROGRAMS
// names daemons that were built otherwise, which run it again, too; APRSIM_JOURNAL_KEEP a file for
// the journal.
TEST(Journal, ReplaysAKilledDaemonToTheSameStates) {
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
  EXPECT_TRUE(std::ranges::none_of(all, &v1::JournalRecord::has_gap));
  const auto checkpoints = checkpoints_of(all);
  ASSERT_GE(checkpoints.size(), 2u);
  // From each to the next, which has the whole state again: so from each to the end. From the one
  // in the middle, and from the last, in one go to the end.
  for (std::size_t i = 0; i + 1 < checkpoints.size(); ++i) {
    expect_same_from(reader->header(), scene, all, checkpoints[i], checkpoints[i + 1]);
  }
  for (const std::size_t first : {checkpoints[checkpoints.size() / 2], checkpoints.back()}) {
    expect_same_from(reader->header(), scene, all, first, all.size() - 1);
  }
  const char* programs = std::getenv("APRSIM_JOURNAL_PROGRAMS");
  std::istringstream words(programs == nullptr ? "" : programs);
  for (std::string program; words >> program;) {
    const auto there = run_process({program, "--replay", file}, std::chrono::hours(1));
    EXPECT_EQ(there.exit_code, 0) << program << there.out << there.err;
    std::printf("%s: %s", program.c_str(), there.out.c_str());
  }
  std::printf("%zu checkpoints, %ju bytes\n%s", checkpoints.size(),
              static_cast<std::uintmax_t>(fs::file_size(file)), again.out.c_str());
  if (const char* keep = std::getenv("APRSIM_JOURNAL_KEEP")) fs::copy_file(file, keep);
}

// APRSIM_JOURNAL_KILLS makes it more thorough.
TEST(Journal, LacksAtMostAMomentWhenTheDaemonIsKilled) {
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

TEST(Journal, RecordsAGapWhenTheDiskFills) {
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

TEST(Journal, RecordsEveryMissingRecordOfAFullDisk) {
  const TemporaryDirectory directory;
  const std::string path = directory.path() + "/small";
  const SmallDisk small(path, "4m");
  if (!small.mounted()) GTEST_SKIP() << "a file system of 4 MB needs root";
  const std::string file = path + "/run.journal";
  DaemonProcess daemon({"--journal", file, "--speed", "max"});
  CellClient cell(daemon.port("grpc"));
  CrclTextClient fanuc(daemon.port("crcl.fanuc"));
  fanuc.send("InitCanonType");
  std::mt19937 random(17);
  const auto until = [&](const std::string& what, const auto& condition) {
    ASSERT_TRUE(eventually(
        [&] {
          fanuc.send("MessageType", "<Message>" + noise(8000, random) + "</Message>");
          fanuc.send("SetEndEffectorType", "<Setting>1</Setting>");
          EXPECT_NE(CrclTextClient::field(fanuc.status(), "CommandState"), "CRCL_Error");
          return condition();
        },
        std::chrono::seconds(60)))
        << what << daemon.log();
  };
  // The rest of a file without room for a large frame takes smaller ones, in further files.
  const auto files = [&] {
    std::vector<std::string> all;
    for (const auto& entry : fs::directory_iterator(path)) all.push_back(entry.path().string());
    std::ranges::sort(all, {}, [](const std::string& name) {
      return std::pair(name.size(), name);  // .10 after .9
    });
    return all;
  };
  const auto gaps = [&] {
    std::vector<v1::JournalGap> all;
    for (const std::string& one : files()) {
      auto reader = journal::JournalReader::open(one);
      if (!reader) continue;  // just begun
      for (const v1::JournalRecord& record : records_of(*reader)) {
        if (record.has_gap()) all.push_back(record.gap());
      }
    }
    return all;
  };
  const auto missing = [&] {
    std::uint64_t records = 0;
    for (const v1::JournalGap& gap : gaps()) records += gap.records();
    return records;
  };
  until("a full disk", [&] { return daemon.log().find("No space left") != std::string::npos; });
  EXPECT_NE(daemon.log().find("records are missing from now on"), std::string::npos);
  EXPECT_GT(fs::file_size(file), std::size_t{2} << 20);
  // The cell goes on, and its metrics and the journal itself tell how much is missing so far.
  const std::uint64_t full = cell.snapshot().step();
  until("further steps", [&] { return cell.snapshot().step() > full + 20'000; });
  EXPECT_GE(metric(daemon, "aprsim_journal_gaps_total"), 1u);
  const std::uint64_t counted = metric(daemon, "aprsim_journal_missing_total");
  EXPECT_GT(counted, 0u);
  until("the gap in the file", [&] { return missing() >= counted; });
  EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  // The log's last word and the journal's are the same, and so are all states beside the gaps.
  const auto told = gaps();
  ASSERT_FALSE(told.empty());
  EXPECT_NE(told.back().reason().find("No space left"), std::string::npos) << told.back().reason();
  EXPECT_TRUE(std::ranges::any_of(told, [](const auto& gap) { return gap.commands() > 0; }));
  EXPECT_NE(daemon.log().find(std::to_string(told.back().records()) + " records are missing, "),
            std::string::npos)
      << told.back().records() << daemon.log();
  const auto again = replay(files());
  EXPECT_EQ(again.exit_code, 0) << again.out << again.err;
  EXPECT_NE(again.out.find(std::to_string(missing()) + " records are missing"), std::string::npos)
      << again.out;
  EXPECT_NE(again.out.find("all states are the same"), std::string::npos) << again.out;
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
  const auto files = [&] {
    std::vector<std::string> out;
    for (const auto& entry : fs::directory_iterator(directory.path())) {
      out.push_back(entry.path().string());
    }
    std::ranges::sort(out);
    return out;
  };
  {
    DaemonProcess daemon({"--journal", directory.path(), "--set", "journal.max_file_mb=1",
                          "--no-web", "--speed", "max"});
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(120);
    work(daemon, [&](CellClient& /*cell*/) {
      return files().size() > 1 || std::chrono::steady_clock::now() > deadline;
    });
    EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  }
  ASSERT_GT(files().size(), 1U);
  const auto again = replay(files());
  EXPECT_EQ(again.exit_code, 0) << again.out << again.err;
  EXPECT_EQ(again.out.find("ends early"), std::string::npos) << again.out;
  // The directory stands for them.
  const auto whole = replay({directory.path()});
  EXPECT_EQ(whole.exit_code, 0) << whole.out << whole.err;
  EXPECT_EQ(whole.out, again.out);
}

TEST(Journal, RefusesOtherFiles) {
  const TemporaryDirectory directory;
  const std::string file = directory.path() + "/none.journal";
  auto refused = replay({file});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find(file), std::string::npos) << refused.err;
  refused = replay({directory.path()});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("has no files *.journal"), std::string::npos) << refused.err;
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
