#include "protocols/access/audit_log.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include <fmt/chrono.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

namespace aprsim::protocols {
namespace {

Result<int> open_file(const std::string& path) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (fd >= 0) return fd;
  return fail(ErrorCode::kUnavailable, "access.audit_file",
              "access.audit_file: cannot write " + path + ": " + std::strerror(errno));
}

/// The time in UTC with milliseconds.
std::string text(std::chrono::system_clock::time_point time) {
  const auto ms =
      std::chrono::duration_cast<std::chrono::milliseconds>(time.time_since_epoch()).count();
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(time)), ms % 1000);
}

std::string line_of(const AuditRecord& record, const api::Snapshot& snapshot) {
  nlohmann::ordered_json object{{"time", text(record.time)}, {"epoch", snapshot.epoch},
                                {"step", snapshot.step},     {"wire", record.wire},
                                {"peer", record.peer},       {"identity", record.identity},
                                {"command", record.command}};
  if (!record.request.empty()) object["request"] = record.request.substr(0, AuditLog::kMaxRequest);
  if (!record.outcome.empty()) object["outcome"] = record.outcome;
  // Requests may hold bytes that are not UTF-8.
  return object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

}  // namespace

Result<std::unique_ptr<AuditLog>> AuditLog::open(const std::string& path,
                                                 const api::SnapshotSource& source) {
  const auto fd = open_file(path);
  if (!fd) return tl::unexpected(fd.error());
  return std::unique_ptr<AuditLog>(new AuditLog(path, *fd, source));
}

AuditLog::AuditLog(std::string path, int fd, const api::SnapshotSource& source)
    : path_(std::move(path)), source_(source), fd_(fd), thread_([this] { run(); }) {}

AuditLog::~AuditLog() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_one();
  thread_.join();
  ::close(fd_);
}

void AuditLog::write(const AuditRecord& record) {
  std::string line = line_of(record, *source_.latest());
  {
    const std::lock_guard lock(mutex_);
    if (waiting_bytes_ + line.size() > kMaxWaiting) {
      ++stats_.lost;
      return;
    }
    waiting_bytes_ += line.size();
    waiting_.push_back(std::move(line));
  }
  changed_.notify_one();
}

Result<void> AuditLog::reopen() {
  const auto fd = open_file(path_);
  if (!fd) return tl::unexpected(fd.error());
  // The thread may be writing, so the new file replaces the old one under its descriptor.
  const int moved = ::dup3(*fd, fd_, O_CLOEXEC);
  ::close(*fd);
  if (moved >= 0) return {};
  return fail(ErrorCode::kUnavailable, "access.audit_file",
              "access.audit_file: cannot change to " + path_ + ": " + std::strerror(errno));
}

AuditStats AuditLog::stats() const {
  const std::lock_guard lock(mutex_);
  return stats_;
}

void AuditLog::run() {
  std::unique_lock lock(mutex_);
  bool failing = false;
  while (true) {
    changed_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    std::deque<std::string> lines;
    std::swap(lines, waiting_);
    waiting_bytes_ = 0;
    const std::uint64_t lost = stats_.lost - reported_;
    lock.unlock();
    bool reported = lost == 0;
    if (!reported) reported = append(fd_, fmt::format("{{\"lost\":{}}}\n", lost));
    std::uint64_t written = 0;
    for (const std::string& line : lines) written += append(fd_, line) ? 1 : 0;
    const bool fails = written < lines.size();
    if (fails && !failing) {
      spdlog::error("access.audit_file: cannot write {}: {}", path_, std::strerror(errno));
    }
    failing = fails;
    lock.lock();
    if (reported) reported_ += lost;
    stats_.records += written;
    stats_.lost += lines.size() - written;
  }
}

bool AuditLog::append(int fd, const std::string& line) const {
  std::size_t done = 0;
  while (done < line.size()) {
    const ssize_t written = ::write(fd, line.data() + done, line.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    done += static_cast<std::size_t>(written);
  }
  return true;
}

}  // namespace aprsim::protocols
