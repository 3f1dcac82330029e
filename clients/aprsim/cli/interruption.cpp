#include "clients/aprsim/cli/interruption.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <fcntl.h>
#include <poll.h>
#include <stdexcept>
#include <unistd.h>

namespace aprsim::client::interruption {
namespace {

// State of the handler, which runs in any thread at any time.
std::atomic<int> holds = 0;
std::atomic<int> cleanups = 0;
std::atomic<int> first_signal = 0;
std::array<int, 2> wake_pipe{-1, -1};
static_assert(std::atomic<int>::is_always_lock_free);

void die_of(int signal) {
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

extern "C" void on_signal(int signal) {
  const int saved_errno = errno;
  int none = 0;
  const bool is_first = first_signal.compare_exchange_strong(none, signal);
  // Every further line on a broken pipe raises SIGPIPE again; that is no request to exit at once.
  if (holds == 0 || (!is_first && signal != SIGPIPE)) {
    if (signal == SIGTERM) _exit(kExitCode);
    die_of(signal);
  } else if (is_first) {
    const char byte = 0;
    [[maybe_unused]] const ssize_t written = write(wake_pipe[1], &byte, 1);
  }
  errno = saved_errno;
}

}  // namespace

void install() {
  if (pipe2(wake_pipe.data(), O_CLOEXEC | O_NONBLOCK) != 0) throw std::runtime_error("no pipe");
  struct sigaction action = {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) {
    struct sigaction before = {};
    sigaction(signal, nullptr, &before);
    if (signal == SIGHUP && before.sa_handler == SIG_IGN) continue;
    sigaction(signal, &action, nullptr);
  }
}

Hold::Hold() { ++holds; }
Hold::~Hold() { --holds; }

Cleanup::Cleanup() { ++cleanups; }
Cleanup::~Cleanup() { --cleanups; }

bool requested() { return happened() && cleanups == 0; }

bool happened() { return first_signal != 0; }

void sleep_until(std::chrono::steady_clock::time_point time) {
  while (!requested()) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(time - std::chrono::steady_clock::now());
    if (left.count() <= 0) return;
    pollfd waiting{cleanups == 0 ? wake_pipe[0] : -1, POLLIN, 0};
    poll(&waiting, 1, static_cast<int>(std::min<long>(left.count(), 1 << 30)));
  }
}

int exit_process() {
  if (first_signal == SIGINT) die_of(SIGINT);
  return kExitCode;
}

}  // namespace aprsim::client::interruption
