#include "world/base/process/input_end.hpp"

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <poll.h>
#include <thread>
#include <unistd.h>

namespace aprsim::process {
namespace {

constexpr std::chrono::seconds kTimeToStop{30};

/// Reads and discards; returns at the end or a failure of the file.
void read_to_end(int file) {
  std::array<char, 512> discarded{};
  while (true) {
    const ssize_t size = read(file, discarded.data(), discarded.size());
    if (size > 0 || (size < 0 && errno == EINTR)) continue;
    if (size == 0 || (errno != EAGAIN && errno != EWOULDBLOCK)) return;
    pollfd waiting{file, POLLIN, 0};
    poll(&waiting, 1, -1);
  }
}

}  // namespace

void stop_when_input_ends() {
  std::thread([] {
    // Signals are for the threads that wait for them.
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, nullptr);
    read_to_end(STDIN_FILENO);
    kill(getpid(), SIGTERM);
    std::this_thread::sleep_for(kTimeToStop);
    kill(getpid(), SIGKILL);
  }).detach();
}

}  // namespace aprsim::process
