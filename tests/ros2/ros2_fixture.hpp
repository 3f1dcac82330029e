#pragma once

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <memory>
#include <spawn.h>
#include <stdexcept>
#include <string>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "tests/ros2/fast_dds_node.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/eventually.hpp"

extern char** environ;

namespace aprsim::test {

using namespace std::chrono_literals;

inline constexpr auto kLongest = 120s * kPatience;
inline const std::string kProgram = APRSIM_BIN_DIR "/aprsim-ros2";

/// The loopback without multicast, for CycloneDDS.
inline void use_loopback() {
  setenv("CYCLONEDDS_URI",
         "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"lo\"/></Interfaces>"
         "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto"
         "</ParticipantIndex><Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery></Domain>"
         "</CycloneDDS>",
         1);
}

/// A domain whose ports are probably free: tests run side by side.
inline unsigned some_domain() { return 1 + static_cast<unsigned>(getpid()) % 90; }

/// The program, until stop().
class Program {
 public:
  explicit Program(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), kProgram);
    std::vector<char*> argv;
    for (auto& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    if (posix_spawn(&pid_, kProgram.c_str(), nullptr, nullptr, argv.data(), environ) != 0) {
      throw std::runtime_error("cannot start " + kProgram);
    }
  }
  ~Program() {
    if (pid_ > 0) stop(SIGKILL);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// The exit code; negative = killed by that signal.
  int stop(int signal) {
    int status = 0;
    kill(pid_, signal);
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  pid_t pid_ = -1;
};

/// A stepped daemon with aprsim-ros2 beside it, and a participant of Fast DDS.
class Ros2 : public ::testing::Test {
 protected:
  Ros2() : Ros2(std::vector<std::string>{}) {}
  /// With arguments for the daemon.
  explicit Ros2(std::vector<std::string> arguments) {
    use_loopback();
    arguments.insert(arguments.end(), {"--speed", "stepped"});
    daemon_ = std::make_unique<DaemonProcess>(arguments);
    domain_ = some_domain();
    fast_dds_ = std::make_unique<FastDdsNode>(domain_);
    program_ = std::make_unique<Program>(std::vector<std::string>{
        "--ports-file", daemon_->ports_file(), "--domain", std::to_string(domain_)});
  }

  /// Waits until something is so.
  static bool wait_for(const std::function<bool()>& met) {
    return eventually(
        [&] {
          std::this_thread::sleep_for(5ms);
          return met();
        },
        kLongest);
  }

  /// Takes samples of a topic until one meets the condition.
  bool take_until(const std::string& topic,
                  const std::function<bool(const std::vector<unsigned char>&)>& met) {
    return eventually(
        [&] {
          std::this_thread::sleep_for(5ms);
          const auto sample = fast_dds_->take(topic);
          return !sample.empty() && met(sample);
        },
        kLongest);
  }

  unsigned domain_ = 0;
  std::unique_ptr<DaemonProcess> daemon_;
  std::unique_ptr<FastDdsNode> fast_dds_;
  std::unique_ptr<Program> program_;
};

}  // namespace aprsim::test
