#include "server/operations/log_sink.hpp"

#include <array>
#include <atomic>
#include <csignal>
#include <fcntl.h>
#include <memory>
#include <string>
#include <thread>
#include <unistd.h>
#include <utility>

#include <gtest/gtest.h>
#include <spdlog/logger.h>

namespace aprsim::server {
namespace {

using namespace std::chrono_literals;

/// A logger into a pipe.
class LogSinkTest : public testing::Test {
 protected:
  LogSinkTest() {
    EXPECT_EQ(pipe2(ends_.data(), O_CLOEXEC), 0);
    sink_ = std::make_shared<LogSink>(ends_[1], [this] { return lost_.load(); });
    logger_ = std::make_unique<spdlog::logger>("test", sink_);
    logger_->set_pattern("%l %v");
  }
  ~LogSinkTest() override {
    for (const int end : ends_) {
      if (end >= 0) close(end);
    }
  }

  /// Lines of a kilobyte, more than the pipe holds.
  static constexpr int kMany = 200;

  /// All that is there; waits for something.
  std::string read_some() {
    std::array<char, 1 << 17> buffer{};
    const ssize_t size = read(ends_[0], buffer.data(), buffer.size());
    return {buffer.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0))};
  }

  std::array<int, 2> ends_{};
  std::atomic<std::uint64_t> lost_{0};
  std::shared_ptr<LogSink> sink_;
  std::unique_ptr<spdlog::logger> logger_;
};

TEST_F(LogSinkTest, WritesLinesAndHowManyWereLost) {
  logger_->info("one");
  EXPECT_EQ(read_some(), "info one\n");
  lost_ = 3;
  logger_->info("two");
  EXPECT_EQ(read_some(), "warning 3 log lines lost: their reader was too slow\ninfo two\n");
  logger_->error("three");
  EXPECT_EQ(read_some(), "error three\n");
}

TEST_F(LogSinkTest, WaitsForItsReader) {
  const std::string line(1000, 'x');
  std::atomic<int> written{0};
  std::jthread writer([&] {
    for (int i = 0; i < kMany; ++i, ++written) logger_->info(line);
  });
  std::string all;
  while (all.size() < kMany * (line.size() + 6)) all += read_some();
  writer.join();
  EXPECT_EQ(written, kMany);
}

TEST_F(LogSinkTest, GivesUpAtItsDeadline) {
  const auto began = LogSink::Clock::now();
  sink_->give_up_at(began + 100ms);
  for (int i = 0; i < kMany; ++i) logger_->info(std::string(1000, 'x'));
  EXPECT_GE(LogSink::Clock::now() - began, 100ms);
  EXPECT_LT(LogSink::Clock::now() - began, 60s);
  // Lost lines are reported when there is a reader again.
  read_some();
  logger_->info("again");
  const std::string text = read_some();
  EXPECT_NE(text.find(" log lines lost: their reader was too slow\ninfo again\n"),
            std::string::npos)
      << text;
}

TEST_F(LogSinkTest, AReaderThatHasGoneIsNotWaitedFor) {
  close(std::exchange(ends_[0], -1));
  std::signal(SIGPIPE, SIG_IGN);
  for (int i = 0; i < kMany; ++i) logger_->info(std::string(1000, 'x'));
}

}  // namespace
}  // namespace aprsim::server
