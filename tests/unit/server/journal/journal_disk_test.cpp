// Files of a journal where they cannot be written as fast as they come, or not at all.

#include "server/journal/journal_disk.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "proto/journal/journal_reader.hpp"
#include "tests/support/small_disk.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::server::journal {
namespace {

using std::chrono::steady_clock;

/// A frame of one record of the step, which nothing compresses.
Frame frame(std::uint64_t step, std::size_t bytes = 0, bool begins = true) {
  v1::JournalRecord record;
  auto& checkpoint = *record.mutable_checkpoint();
  checkpoint.mutable_time()->set_step(step);
  std::uint64_t random = step + 1;
  for (std::size_t i = 0; i < bytes; ++i) {
    random = random * 6364136223846793005U + 1442695040888963407U;
    checkpoint.mutable_state()->push_back(static_cast<char>(random >> 56U));
  }
  aprsim::journal::FrameEncoder encoder;
  encoder.add(record);
  const auto now = std::chrono::system_clock::now();
  return {.bytes = std::make_shared<const std::string>(encoder.take()),
          .records = 1,
          .held = {1, 0, now, now, {}},
          .begins = begins};
}

struct Read {
  std::vector<std::uint64_t> steps;
  std::uint64_t gaps = 0, missing = 0;
  std::string reason, damage;
};

Read read(const std::string& file) {
  auto reader = aprsim::journal::JournalReader::open(file);
  if (!reader) throw std::runtime_error(reader.error().message);
  Read out;
  for (v1::JournalRecord record; reader->next(record);) {
    if (record.has_checkpoint()) out.steps.push_back(record.checkpoint().time().step());
    if (!record.has_gap()) continue;
    ++out.gaps;
    out.missing += record.gap().records();
    out.reason = record.gap().reason();
  }
  out.damage = reader->damage();
  return out;
}

class JournalDiskTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { std::signal(SIGPIPE, SIG_IGN); }
  JournalDiskTest() { header_.set_format(aprsim::journal::kFormat); }
  static steady_clock::time_point soon() { return steady_clock::now() + std::chrono::seconds(10); }

  test::TemporaryDirectory directory_;
  v1::JournalHeader header_;
};

TEST_F(JournalDiskTest, AFifoThatIsNotReadIsNotWaitedForAndItsGapIsTold) {
  const std::string fifo = directory_.path() + "/fifo", copy = directory_.path() + "/copy";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  const int reader = ::open(fifo.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  JournalDisk disk(fifo, std::uint64_t{1} << 30, header_);
  // A pipe takes 64 KB, and 16 MB wait for its reader.
  constexpr std::uint64_t kFrames = 40;
  for (std::uint64_t step = 0; step < kFrames; ++step) disk.append(frame(step, 1 << 20));
  EXPECT_TRUE(disk.wants_beginning());
  // The statistics report the gap while nobody reads.
  EXPECT_EQ(disk.stats().gaps, 1U);
  EXPECT_GE(disk.stats().missing, 20U);
  // Now it is read.
  std::ofstream out(copy, std::ios::binary);
  std::vector<char> buffer(1 << 16);
  const auto drain = [&] {
    ssize_t got = 0;
    while ((got = ::read(reader, buffer.data(), buffer.size())) > 0) {
      out.write(buffer.data(), got);
      disk.write_waiting();
    }
  };
  drain();
  disk.append(frame(kFrames));
  drain();
  disk.finish(soon());
  drain();
  out.close();
  ::close(reader);
  const Read seen = read(copy);
  EXPECT_EQ(seen.damage, "");
  EXPECT_EQ(seen.gaps, 1U);
  EXPECT_NE(seen.reason.find("keep up"), std::string::npos) << seen.reason;
  EXPECT_GE(seen.steps.size(), 15U);
  EXPECT_EQ(seen.steps.size() + seen.missing, kFrames + 1);
  EXPECT_EQ(seen.steps.back(), kFrames);
  EXPECT_EQ(disk.stats().missing, seen.missing);
  EXPECT_EQ(disk.stats().gaps, 1U);
}

/// All files of a directory or beside a file, by name.
std::vector<std::string> names_in(const std::string& directory) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    names.push_back(entry.path().filename().string());
  }
  std::ranges::sort(names);
  return names;
}

TEST_F(JournalDiskTest, RunsInOneDirectoryHaveFilesOfTheirOwn) {
  v1::JournalHeader other = header_;
  header_.set_run_id("first");
  other.set_run_id("second");
  JournalDisk one(directory_.path(), 1 << 20, header_), two(directory_.path(), 1 << 20, other);
  one.append(frame(1));
  two.append(frame(2));
  one.finish(soon());
  two.finish(soon());
  const auto names = names_in(directory_.path());
  ASSERT_EQ(names.size(), 2U);
  EXPECT_EQ(read(directory_.path() + '/' + names[0]).steps.size(), 1U);
  EXPECT_EQ(read(directory_.path() + '/' + names[1]).steps.size(), 1U);
}

/// As after a crash and a restart by systemd.
TEST_F(JournalDiskTest, ARunBeforeInTheSameFileIsKept) {
  const std::string file = directory_.path() + "/run.journal";
  for (std::uint64_t run = 1; run <= 3; ++run) {
    // Small files, so that each run has three.
    JournalDisk disk(file, 1, header_);
    ASSERT_TRUE(disk.claim());
    for (std::uint64_t part = 0; part < 3; ++part) disk.append(frame(10 * run + part));
    disk.finish(soon());
  }
  EXPECT_EQ(names_in(directory_.path()),
            (std::vector<std::string>{"run.journal", "run.journal.2", "run.journal.3",
                                      "run.journal.old-1", "run.journal.old-1.2",
                                      "run.journal.old-1.3", "run.journal.old-2",
                                      "run.journal.old-2.2", "run.journal.old-2.3"}));
  EXPECT_EQ(read(file + ".old-1.3").steps, std::vector<std::uint64_t>{12});
  EXPECT_EQ(read(file + ".old-2").steps, std::vector<std::uint64_t>{20});
  EXPECT_EQ(read(file).steps, std::vector<std::uint64_t>{30});
}

TEST_F(JournalDiskTest, AFileThatAnotherRunRecordsInIsRefused) {
  const std::string file = directory_.path() + "/run.journal";
  JournalDisk first(file, 1, header_), second(file, 1, header_);
  ASSERT_TRUE(first.claim());
  first.append(frame(1));
  first.append(frame(2));  // its first file is closed by now
  const auto refused = second.claim();
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("another process records"), std::string::npos)
      << refused.error().message;
  first.append(frame(3));
  first.finish(soon());
  EXPECT_EQ(read(file).steps, std::vector<std::uint64_t>{1});
  EXPECT_EQ(read(file + ".2").steps, std::vector<std::uint64_t>{2});
}

TEST_F(JournalDiskTest, OthersCannotReadItsFiles) {
  const mode_t before = ::umask(0);
  JournalDisk one(directory_.path() + "/run.journal", 1, header_),
      two(directory_.path(), 1, header_);
  for (JournalDisk* disk : {&one, &two}) {
    disk->append(frame(1));
    disk->append(frame(2));
    disk->finish(soon());
  }
  ::umask(before);
  const auto names = names_in(directory_.path());
  EXPECT_EQ(names.size(), 4U);
  for (const std::string& name : names) {
    struct stat status {};
    ASSERT_EQ(::stat((directory_.path() + '/' + name).c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777U, 0600U) << name;
  }
}

TEST_F(JournalDiskTest, LinksToFilesAreNotFollowed) {
  const std::string target = directory_.write("target", "not ours"),
                    file = directory_.path() + "/run.journal";
  for (const std::string& to : {target, directory_.path() + "/missing"}) {
    std::filesystem::create_symlink(to, file);
    JournalDisk disk(file, 1, header_);
    const auto refused = disk.claim();
    ASSERT_FALSE(refused) << to;
    EXPECT_NE(refused.error().message.find("symbolic link"), std::string::npos);
    std::filesystem::remove(file);
  }
  // A hard link is renamed as any file, and keeps what it had.
  std::filesystem::create_hard_link(target, file);
  JournalDisk disk(file, 1, header_);
  disk.append(frame(1));
  disk.finish(soon());
  std::string content;
  std::getline(std::ifstream(target), content);
  EXPECT_EQ(content, "not ours");
  EXPECT_EQ(read(file).steps.size(), 1U);
}

/// File names are bytes; strings of protobuf are UTF-8.
TEST_F(JournalDiskTest, ANameThatIsNoUtf8CanBeReadAgain) {
  header_.set_configuration("journal:\n  place: caf\xe9/run.journal\n");
  const std::string file = directory_.path() + "/caf\xe9.journal";
  JournalDisk disk(file, 1, header_);
  disk.append(frame(1));
  disk.finish(soon());
  auto reader = aprsim::journal::JournalReader::open(file);
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_EQ(reader->header().configuration(), "journal:\n  place: caf\\xe9/run.journal\n");
}

TEST_F(JournalDiskTest, AFifoWithoutAReaderHoldsNobodyUp) {
  const std::string fifo = directory_.path() + "/fifo";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  JournalDisk disk(fifo, std::uint64_t{1} << 30, header_);
  for (std::uint64_t step = 0; step < 100; ++step) disk.append(frame(step));
  disk.finish(soon());
  EXPECT_EQ(disk.stats().records, 0U);
}

TEST_F(JournalDiskTest, AReaderThatLeavesIsAGapForTheNext) {
  const std::string fifo = directory_.path() + "/fifo", copy = directory_.path() + "/copy";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  const int first = ::open(fifo.c_str(), O_RDONLY | O_NONBLOCK);
  JournalDisk disk(fifo, std::uint64_t{1} << 30, header_);
  disk.append(frame(1));
  ::close(first);
  disk.append(frame(2));
  const int second = ::open(fifo.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(second, 0);
  const auto deadline = soon();
  while (!disk.wants_beginning() && steady_clock::now() < deadline) {
  }
  disk.append(frame(3));
  disk.finish(soon());
  std::string bytes(1 << 16, '\0');
  const ssize_t got = ::read(second, bytes.data(), bytes.size());
  ::close(second);
  ASSERT_GT(got, 0);
  std::ofstream(copy, std::ios::binary) << bytes.substr(0, static_cast<std::size_t>(got));
  const Read seen = read(copy);
  EXPECT_EQ(seen.damage, "");
  EXPECT_EQ(seen.steps, std::vector<std::uint64_t>{3});
  EXPECT_EQ(seen.gaps, 1U);
  EXPECT_EQ(seen.missing, 1U);
}

TEST_F(JournalDiskTest, ADiskThatRunsFullLeavesWholeFramesAndItsGapIsTold) {
  const std::string path = directory_.path() + "/small";
  const test::SmallDisk small(path, "4m");
  if (!small.mounted()) GTEST_SKIP() << "a file system of 4 MB needs root";
  const std::string file = path + "/run.journal", filler = path + "/filler";
  std::ofstream(filler) << std::string(1 << 20, 'x');
  JournalDisk disk(file, std::uint64_t{1} << 30, header_);
  for (std::uint64_t step = 0; step < 10; ++step) disk.append(frame(step, 1 << 20));
  const Read full = read(file);
  EXPECT_EQ(full.damage, "");
  EXPECT_EQ(full.steps, (std::vector<std::uint64_t>{0, 1}));
  // A reader now sees the records missing so far.
  EXPECT_EQ(full.gaps, 1U);
  EXPECT_EQ(full.missing, 1U);
  disk.write_waiting();
  EXPECT_EQ(read(file).missing, 8U);
  EXPECT_EQ(disk.stats().missing, 8U);
  // Somebody makes room.
  std::filesystem::remove(filler);
  const auto deadline = soon();
  while (!disk.wants_beginning() && steady_clock::now() < deadline) {
  }
  disk.append(frame(10));
  disk.finish(soon());
  const Read rest = read(file + ".2");
  EXPECT_EQ(rest.damage, "");
  EXPECT_EQ(rest.steps, std::vector<std::uint64_t>{10});
  EXPECT_EQ(rest.gaps, 1U);
  EXPECT_EQ(rest.missing, 8U);
  EXPECT_NE(rest.reason.find("No space left"), std::string::npos) << rest.reason;
  // The gap is recorded once.
  EXPECT_EQ(read(file).gaps, 0U);
  EXPECT_EQ(read(file).steps, full.steps);
}

TEST_F(JournalDiskTest, AFileThatHasNoRoomForItsHeaderIsNotLeftBehind) {
  const std::string path = directory_.path() + "/small";
  const test::SmallDisk small(path, "64k");
  if (!small.mounted()) GTEST_SKIP() << "a file system needs root";
  const std::string file = path + "/run.journal";
  std::ofstream(path + "/filler") << std::string(64 << 10, 'x');
  JournalDisk disk(file, std::uint64_t{1} << 30, header_);
  disk.append(frame(0));
  EXPECT_FALSE(std::filesystem::exists(file));
  EXPECT_EQ(disk.stats().missing, 1U);
}

}  // namespace
}  // namespace aprsim::server::journal
