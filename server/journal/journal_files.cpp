#include "server/journal/journal_files.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include <spdlog/spdlog.h>

namespace aprsim::server::journal {
namespace {

constexpr const char* kInUse = ": another process records a run there";

}  // namespace

JournalFiles::JournalFiles(std::string place, std::string stamp, std::uint64_t max_bytes)
    : place_(std::move(place)), stamp_(std::move(stamp)), max_bytes_(max_bytes) {}

JournalFiles::~JournalFiles() {
  close();
  forget_given_up();
  for (const int descriptor : {first_, lock_}) {
    if (descriptor >= 0) ::close(descriptor);
  }
}

std::string JournalFiles::name_of(std::uint32_t part) const {
  std::error_code none;
  if (std::filesystem::is_directory(place_, none)) {
    return (std::filesystem::path(place_) /
            ("aprsim-" + stamp_ + "-" + std::to_string(part) + ".journal"))
        .string();
  }
  // A FIFO stays what it is.
  const bool numbered = part > 1 && std::filesystem::is_regular_file(place_, none);
  return numbered ? place_ + "." + std::to_string(part) : place_;
}

tl::unexpected<Error> JournalFiles::failed(const char* what, int error) const {
  return fail(ErrorCode::kUnavailable, "journal",
              file_ + ": " + what + ": " + std::strerror(error));
}

Result<void> JournalFiles::claim() {
  if (claimed_) return {};
  file_ = name_of(1);
  std::error_code none;
  if (!std::filesystem::is_directory(place_, none)) {
    if (auto kept = keep_earlier_run(); !kept) return kept;
    const auto first = open_file();
    if (!first) return tl::unexpected(first.error());
    first_ = *first;
    if (::flock(first_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      ::close(std::exchange(first_, -1));
      return fail(ErrorCode::kUnavailable, "journal", file_ + kInUse);
    }
    // A FIFO must close with its reader: what that one left is not for the next.
    struct stat status {};
    if (::fstat(first_, &status) == 0 && S_ISREG(status.st_mode)) {
      lock_ = ::fcntl(first_, F_DUPFD_CLOEXEC, 0);
    }
  }
  claimed_ = true;
  return {};
}

Result<void> JournalFiles::keep_earlier_run() const {
  struct stat status {};
  if (::lstat(place_.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return {};
  const int earlier = ::open(place_.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK);
  if (earlier < 0) return failed("cannot be opened", errno);
  const bool in_use = ::flock(earlier, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(earlier);
  if (in_use) return fail(ErrorCode::kUnavailable, "journal", file_ + kInUse);
  std::error_code error;
  std::string old;
  for (int number = 1; old.empty() || std::filesystem::exists(old, error); ++number) {
    old = place_ + ".old-" + std::to_string(number);
  }
  for (std::uint32_t part = 1;; ++part) {
    const std::string suffix = part == 1 ? "" : "." + std::to_string(part);
    const std::string name = place_ + suffix;
    if (!std::filesystem::exists(name, error)) break;
    if (::rename(name.c_str(), (old + suffix).c_str()) != 0) {
      return failed("the earlier run there cannot be renamed", errno);
    }
  }
  spdlog::info("journal: {} is kept as {}", place_, old);
  return {};
}

Result<int> JournalFiles::open_file() const {
  // A FIFO that nobody reads, or not fast enough, must not block.
  constexpr int kFlags = O_WRONLY | O_CLOEXEC | O_NONBLOCK;
  struct stat status {};
  if (::stat(file_.c_str(), &status) == 0 && !S_ISREG(status.st_mode)) {
    const int descriptor = ::open(file_.c_str(), kFlags);
    if (descriptor < 0) {
      const int error = errno;
      return failed(error == ENXIO ? "nobody reads it" : "cannot be opened", error);
    }
    if (::fstat(descriptor, &status) == 0 && !S_ISREG(status.st_mode)) return descriptor;
    ::close(descriptor);
  }
  const int descriptor = ::open(file_.c_str(), kFlags | O_CREAT | O_EXCL, S_IRUSR | S_IWUSR);
  if (descriptor >= 0) return descriptor;
  const int error = errno;
  if (error == EEXIST && ::lstat(file_.c_str(), &status) == 0 && S_ISLNK(status.st_mode)) {
    return fail(ErrorCode::kUnavailable, "journal",
                file_ + ": a journal is not written through a symbolic link; name the file");
  }
  return failed("cannot be opened", error);
}

Result<void> JournalFiles::open_next() {
  close();
  if (auto claimed = claim(); !claimed) return claimed;
  file_ = name_of(part_ + 1);
  if (first_ >= 0) {
    descriptor_ = std::exchange(first_, -1);
  } else if (const auto opened = open_file()) {
    descriptor_ = *opened;
  } else {
    return tl::unexpected(opened.error());
  }
  struct stat status {};
  regular_ = ::fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode);
  size_ = 0;
  return {};
}

Result<std::size_t> JournalFiles::append(std::string_view rest) {
  std::size_t done = 0;
  while (done < rest.size()) {
    const ssize_t wrote = ::write(descriptor_, rest.data() + done, rest.size() - done);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0 && errno == EAGAIN && !regular_) return done;
    if (wrote <= 0) {
      const int error = wrote == 0 ? ENOSPC : errno;
      if (regular_ && ::ftruncate(descriptor_, static_cast<off_t>(size_)) == 0) {
        ::lseek(descriptor_, static_cast<off_t>(size_), SEEK_SET);
      }
      return failed("cannot be written", error);
    }
    done += static_cast<std::size_t>(wrote);
  }
  size_ += rest.size();
  return done;
}

bool JournalFiles::wait_writable(std::chrono::milliseconds time) const {
  pollfd state{.fd = descriptor_, .events = POLLOUT, .revents = 0};
  return ::poll(&state, 1, static_cast<int>(time.count())) > 0;
}

void JournalFiles::give_up() {
  if (regular_ && descriptor_ >= 0) {
    if (size_ == 0) {
      ::unlink(file_.c_str());
    } else {
      forget_given_up();
      given_up_ = {std::exchange(descriptor_, -1), size_};
    }
  }
  close();
}

bool JournalFiles::end_with(std::string_view frame) {
  const auto [descriptor, size] = given_up_;
  const auto behind = static_cast<off_t>(size);
  if (descriptor < 0 || ::ftruncate(descriptor, behind) != 0) return false;
  const ssize_t wrote = ::pwrite(descriptor, frame.data(), frame.size(), behind);
  if (wrote == static_cast<ssize_t>(frame.size())) return true;
  // Nothing that is half written.
  (void)(::ftruncate(descriptor, behind) == 0);
  return false;
}

void JournalFiles::begun() {
  ++part_;
  if (!gave_up()) return;
  end_with({});
  forget_given_up();
}

void JournalFiles::forget_given_up() {
  if (gave_up()) ::close(std::exchange(given_up_, {}).descriptor);
}

void JournalFiles::close() {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
}

}  // namespace aprsim::server::journal
