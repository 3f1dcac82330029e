#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string_view>

#include <spdlog/sinks/base_sink.h>

namespace aprsim::server {

/// Writes log lines to a descriptor whose reader may stall. It waits for the reader, at the end of
/// the process until a deadline. When the reader reads again, the first line reports how many lines
/// were lost. Thread: one writes; give_up_at() any.
class LogSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  using Clock = std::chrono::steady_clock;

  /// The caller owns the descriptor. `lost` counts lines that never reached this sink.
  explicit LogSink(
      int fd, std::function<std::uint64_t()> lost = [] { return 0; });

  /// Drops lines that cannot be written by then.
  void give_up_at(Clock::time_point deadline) { deadline_ = deadline.time_since_epoch().count(); }

 protected:
  void sink_it_(const spdlog::details::log_msg& line) override;
  void flush_() override {}

 private:
  [[nodiscard]] bool write(const spdlog::details::log_msg& line);
  [[nodiscard]] bool write(std::string_view text);
  [[nodiscard]] bool wait_until_writable() const;

  const int fd_;
  const bool colors_;
  const std::function<std::uint64_t()> lost_elsewhere_;
  std::uint64_t lost_here_ = 0, reported_ = 0;
  std::atomic<Clock::rep> deadline_{Clock::duration::max().count()};
};

}  // namespace aprsim::server
