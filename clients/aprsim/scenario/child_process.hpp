#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

#include "clients/aprsim/outcome.hpp"

namespace aprsim::client {

/// A program that we start and end, in a process group of its own, so that Ctrl-C reaches it
/// through us. It is told to end when we die. Thread: one.
class ChildProcess {
 public:
  enum class Pipes { kNone, kInputAndOutput };

  /// `log`: file for its standard error, and for its output where that is no pipe.
  [[nodiscard]] static Outcome<ChildProcess> start(
      const std::vector<std::string>& arguments,
      const std::vector<std::pair<std::string, std::string>>& environment, const std::string& log,
      Pipes pipes);
  /// Kills what still runs.
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;

  /// Whole lines that it has written since the last call; never waits.
  [[nodiscard]] std::vector<std::string> lines();
  /// A line to its input; what it does not read in time is lost with it.
  void write_line(const std::string& line);
  void close_input();

  /// Its exit code once it has ended, negative after a signal.
  [[nodiscard]] std::optional<int> ended();
  /// Waits for its end; false when that has not come in time.
  [[nodiscard]] bool wait(std::chrono::milliseconds time);
  void signal(int number) const;
  /// SIGTERM to its group, SIGKILL when it is still there after `time`.
  void stop(std::chrono::milliseconds time);

 private:
  ChildProcess() = default;
  pid_t pid_ = -1;
  int input_ = -1, output_ = -1;
  std::string pending_;
  std::optional<int> exit_code_;
};

}  // namespace aprsim::client
