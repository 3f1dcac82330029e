#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string_view>

#include <spdlog/sinks/base_sink.h>

namespace aprsim::server {

/// Writes log lines to a descriptor whose reader may stall: waits for it, but at the end only until
/// a deadline. When the reader takes lines again, the first tells how many were lost meanwhile.
/// Thread: one writes; give_up_at() any.
class LogSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  using Clock = std::chrono::steady_clock;

  /// The descriptor stays the caller's. `lost` counts the lines that never came here.
  explicit LogSink(
      int fd, std::function<std::uint64_t()> lost = [] { return 0; });

  /// Lines that cannot be written by then are lost.
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
  std::uint64_t lost_here_ = 0, told_ = 0;
  std::atomic<Clock::rep> deadline_{Clock::duration::max().count()};
};

}  // namespace aprsim::server
