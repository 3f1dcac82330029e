#include "server/operations/ports_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <optional>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include <nlohmann/json.hpp>

namespace aprsim::server {
namespace {

constexpr int kAttempts = 100;  // to replace what others replace meanwhile

/// An open file.
class File {
 public:
  explicit File(int fd) : fd_(fd) {}
  ~File() {
    if (fd_ >= 0) ::close(fd_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  [[nodiscard]] int get() const { return fd_; }
  [[nodiscard]] int release() { return std::exchange(fd_, -1); }

 private:
  int fd_;
};

tl::unexpected<Error> refuse(const std::string& path, const std::string& cause) {
  return fail(ErrorCode::kUnavailable, "ports-file", "cannot write " + path + ": " + cause);
}

/// The process that has written the file; 0 = unknown.
pid_t writer_of(const std::string& path) {
  std::ifstream in(path);
  const auto json = nlohmann::json::parse(in, nullptr, false);
  if (!json.is_object() || !json.contains("pid") || !json["pid"].is_number_integer()) return 0;
  const auto pid = json["pid"].get<std::int64_t>();
  return pid > 0 && pid < (1 << 30) ? static_cast<pid_t>(pid) : 0;
}

/// Whether the path still names the open file.
bool is_at(int file, const std::string& path) {
  struct stat open {
  }, named{};
  return ::fstat(file, &open) == 0 && ::lstat(path.c_str(), &named) == 0 &&
         open.st_dev == named.st_dev && open.st_ino == named.st_ino;
}

/// Always succeeds on a file system without locks.
bool lock(int file) { return ::flock(file, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK; }

bool write_all(int file, const std::string& text) {
  const ssize_t written = ::write(file, text.data(), text.size());
  if (written >= 0 && written != static_cast<ssize_t>(text.size())) errno = ENOSPC;
  return written == static_cast<ssize_t>(text.size());
}

/// Renames the draft to a path that does not exist; false with EEXIST when it exists by now.
bool place(const std::string& draft, const std::string& path) {
  if (::renameat2(AT_FDCWD, draft.c_str(), AT_FDCWD, path.c_str(), RENAME_NOREPLACE) == 0) {
    return true;
  }
  // Some file systems do not support the flag.
  return errno == EINVAL && std::rename(draft.c_str(), path.c_str()) == 0;
}

/// Renames the draft to the path, which may exist; absent = the path has changed, try again.
std::optional<Result<void>> replace(const std::string& draft, const std::string& path) {
  const auto failed = [&] {
    return std::optional<Result<void>>(refuse(path, std::strerror(errno)));
  };
  struct stat there {};
  if (::lstat(path.c_str(), &there) != 0) {
    if (errno != ENOENT) return failed();
    if (place(draft, path)) return Result<void>();
    return errno == EEXIST ? std::nullopt : failed();
  }
  if (!S_ISREG(there.st_mode)) return Result<void>(refuse(path, "it is not a regular file"));
  const File old(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  if (old.get() < 0) return errno == ENOENT ? std::nullopt : failed();
  if (!lock(old.get())) {
    const pid_t writer = writer_of(path);
    return Result<void>(refuse(
        path, writer == 0
                  ? "another daemon is writing it"
                  : "it belongs to the running daemon with process id " + std::to_string(writer)));
  }
  // Other daemons fail to lock this file, or find another one.
  if (!is_at(old.get(), path)) return std::nullopt;
  if (std::rename(draft.c_str(), path.c_str()) != 0) return failed();
  return Result<void>();
}

}  // namespace

Result<void> PortsFile::write(const std::string& path, const Ports& ports) {
  nlohmann::json json;
  for (const auto& [name, port] : ports) json[name] = port;
  json["pid"] = ::getpid();
  const std::string draft = path + "." + std::to_string(::getpid()) + ".tmp";
  ::unlink(draft.c_str());
  File file(::open(draft.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644));
  if (file.get() < 0) return refuse(draft, std::strerror(errno));
  Result<void> done = refuse(path, "other processes keep replacing it");
  if (!lock(file.get()) || !write_all(file.get(), json.dump(2) + "\n")) {
    done = refuse(draft, std::strerror(errno));
  } else {
    // Nobody else replaces the file whose lock is ours.
    const bool ours = file_ >= 0 && is_at(file_, path);
    if (ours)
      done = std::rename(draft.c_str(), path.c_str()) == 0 ? Result<void>()
                                                           : refuse(path, std::strerror(errno));
    for (int i = 0; i < kAttempts && !ours; ++i) {
      if (const auto outcome = replace(draft, path)) {
        done = *outcome;
        break;
      }
    }
  }
  if (!done) {
    ::unlink(draft.c_str());
    return done;
  }
  path_ = path;
  if (file_ >= 0) ::close(file_);
  file_ = file.release();
  return done;
}

PortsFile::~PortsFile() { remove(); }

void PortsFile::remove() {
  if (file_ < 0) return;
  try {
    if (is_at(file_, path_) && writer_of(path_) == ::getpid()) ::unlink(path_.c_str());
  } catch (const std::exception&) {
    // Without memory to read it the file stays, unlocked.
  }
  ::close(std::exchange(file_, -1));
}

}  // namespace aprsim::server
