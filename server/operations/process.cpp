#include "server/operations/process.hpp"

#include <cerrno>
#include <csignal>
#include <ctime>
#include <fcntl.h>
#include <filesystem>
#include <malloc.h>
#include <pthread.h>
#include <string>
#include <sys/resource.h>
#include <unistd.h>

namespace aprsim::server {
namespace {

/// sigwait() accepts an ignored signal as well once it is blocked.
bool is_ignored(int signal) {
  struct sigaction action {};
  return sigaction(signal, nullptr, &action) == 0 && (action.sa_flags & SA_SIGINFO) == 0 &&
         action.sa_handler == SIG_IGN;
}

sigset_t stop_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  for (const int signal : {SIGINT, SIGHUP}) {
    if (!is_ignored(signal)) sigaddset(&set, signal);
  }
  return set;
}

}  // namespace

void open_standard_descriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(descriptor, F_GETFD) >= 0 || errno != EBADF) continue;
    // This is the lowest free number, since those below are open. A write to standard output fails,
    // so that lost output is reported.
    if (open("/dev/null", descriptor == STDERR_FILENO ? O_RDWR : O_RDONLY) < 0) return;
  }
}

Result<void> raise_file_limit(std::uint64_t needed) {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return {};
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
  if (limit.rlim_cur >= needed) return {};
  return fail(ErrorCode::kFailedPrecondition, "RLIMIT_NOFILE",
              "at most " + std::to_string(limit.rlim_cur) +
                  " files may be open, the connection limits need " + std::to_string(needed) +
                  "; raise the limit (ulimit -Hn) or lower max_connections");
}

void share_memory_pools() {
  mallopt(M_ARENA_MAX, 2);
  // The default threshold rises to the largest block that was ever freed; the process keeps all
  // blocks below it.
  mallopt(M_MMAP_THRESHOLD, 128 * 1024);
}

void block_signals() {
  const sigset_t set = stop_signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

std::optional<int> wait_for_signal(std::optional<std::chrono::milliseconds> limit) {
  const sigset_t set = stop_signals();
  timespec time{};
  if (limit) {
    time.tv_sec = limit->count() / 1000;
    time.tv_nsec = limit->count() % 1000 * 1'000'000;
  }
  const int signal = limit ? sigtimedwait(&set, nullptr, &time) : sigwaitinfo(&set, nullptr);
  return signal > 0 ? std::optional(signal) : std::nullopt;
}

bool has_terminal() {
  const int terminal = open("/dev/tty", O_RDONLY | O_NOCTTY | O_CLOEXEC);
  if (terminal >= 0) close(terminal);
  return terminal >= 0;
}

void unblock_signals() {
  const sigset_t set = stop_signals();
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

}  // namespace aprsim::server
