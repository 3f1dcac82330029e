// Files of a journal where they cannot be written as fast as they come, or not at all.

#include "server/journal/journal_disk.hpp"

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
  for (std::uint64_t step = 0; step < kFrames; ++step) disk.put(frame(step, 1 << 20));
  EXPECT_TRUE(disk.wants_beginning());
  // Who asks hears of it while nobody reads.
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
  disk.put(frame(kFrames));
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

TEST_F(JournalDiskTest, AFifoWithoutAReaderHoldsNobodyUp) {
  const std::string fifo = directory_.path() + "/fifo";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  JournalDisk disk(fifo, std::uint64_t{1} << 30, header_);
  for (std::uint64_t step = 0; step < 100; ++step) disk.put(frame(step));
  disk.finish(soon());
  EXPECT_EQ(disk.stats().records, 0U);
}

TEST_F(JournalDiskTest, AReaderThatLeavesIsAGapForTheNext) {
  const std::string fifo = directory_.path() + "/fifo", copy = directory_.path() + "/copy";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  const int first = ::open(fifo.c_str(), O_RDONLY | O_NONBLOCK);
  JournalDisk disk(fifo, std::uint64_t{1} << 30, header_);
  disk.put(frame(1));
  ::close(first);
  disk.put(frame(2));
  const int second = ::open(fifo.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(second, 0);
  const auto deadline = soon();
  while (!disk.wants_beginning() && steady_clock::now() < deadline) {
  }
  disk.put(frame(3));
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
  for (std::uint64_t step = 0; step < 10; ++step) disk.put(frame(step, 1 << 20));
  const Read full = read(file);
  EXPECT_EQ(full.damage, "");
  EXPECT_EQ(full.steps, (std::vector<std::uint64_t>{0, 1}));
  // Whoever reads it now sees what is missing so far.
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
  disk.put(frame(10));
  disk.finish(soon());
  const Read rest = read(file + ".2");
  EXPECT_EQ(rest.damage, "");
  EXPECT_EQ(rest.steps, std::vector<std::uint64_t>{10});
  EXPECT_EQ(rest.gaps, 1U);
  EXPECT_EQ(rest.missing, 8U);
  EXPECT_NE(rest.reason.find("No space left"), std::string::npos) << rest.reason;
  // It is told once.
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
  disk.put(frame(0));
  EXPECT_FALSE(std::filesystem::exists(file));
  EXPECT_EQ(disk.stats().missing, 1U);
}

}  // namespace
}  // namespace aprsim::server::journal
