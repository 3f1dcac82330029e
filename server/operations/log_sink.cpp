#include "server/operations/log_sink.hpp"

#include <algorithm>
#include <cerrno>
#include <poll.h>
#include <string>
#include <unistd.h>
#include <utility>

#include <climits>
#include <spdlog/spdlog.h>

namespace aprsim::server {
namespace {

/// Period of checking the deadline of a stalled reader [ms].
constexpr int kCheckMs = 20;

std::string_view color_of(spdlog::level::level_enum level) {
  switch (level) {
    case spdlog::level::warn:
      return "\033[33m\033[1m";
    case spdlog::level::err:
    case spdlog::level::critical:
      return "\033[31m\033[1m";
    case spdlog::level::info:
      return "\033[32m";
    default:
      return "\033[36m";
  }
}

}  // namespace

LogSink::LogSink(int fd, std::function<std::uint64_t()> lost)
    : fd_(fd), colors_(isatty(fd) == 1), lost_elsewhere_(std::move(lost)) {}

void LogSink::sink_it_(const spdlog::details::log_msg& line) {
  const std::uint64_t lost = lost_elsewhere_() + lost_here_;
  if (lost > reported_) {
    const std::string text =
        std::to_string(lost - reported_) + " log lines lost: their reader was too slow";
    if (write({line.logger_name, spdlog::level::warn, text})) reported_ = lost;
  }
  if (!write(line)) ++lost_here_;
}

bool LogSink::write(const spdlog::details::log_msg& line) {
  spdlog::memory_buf_t formatted;
  formatter_->format(line, formatted);
  const std::string_view text(formatted.data(), formatted.size());
  if (!colors_ || line.color_range_end <= line.color_range_start) return write(text);
  std::string colored(text.substr(0, line.color_range_start));
  colored.append(color_of(line.level));
  colored.append(
      text.substr(line.color_range_start, line.color_range_end - line.color_range_start));
  colored.append("\033[m").append(text.substr(line.color_range_end));
  return write(std::string_view(colored));
}

bool LogSink::write(std::string_view text) {
  while (!text.empty()) {
    if (!wait_until_writable()) return false;
    // A writable pipe accepts this much without blocking.
    const ssize_t written = ::write(fd_, text.data(), std::min<std::size_t>(text.size(), PIPE_BUF));
    if (written < 0 && errno != EINTR && errno != EAGAIN) return false;
    if (written > 0) text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

bool LogSink::wait_until_writable() const {
  while (true) {
    const bool late = Clock::now().time_since_epoch().count() >= deadline_;
    pollfd wait{fd_, POLLOUT, 0};
    if (poll(&wait, 1, late ? 0 : kCheckMs) > 0) return true;
    if (late) return false;
  }
}

}  // namespace aprsim::server
