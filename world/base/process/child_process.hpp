#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

#include "world/base/result.hpp"

namespace aprsim::process {

/// A program that we start and end, in a process group of its own, so that Ctrl-C reaches it
/// through us. It inherits no open files and receives a signal to end when the thread that started
/// it ends. Thread: one.
class ChildProcess {
 public:
  static constexpr std::size_t kLongestLine = std::size_t{1} << 20;  ///< [bytes]

  enum class Pipes {
    kNone,
    kInputAndOutput,   ///< standard input and output
    kOutputAndErrors,  ///< standard output and error, in one; no input
  };

  /// `log`: file for whatever of its standard output and error is no pipe. Error: kNotFound with
  /// the program and the cause.
  [[nodiscard]] static Result<ChildProcess> start(
      const std::vector<std::string>& arguments,
      const std::vector<std::pair<std::string, std::string>>& environment, const std::string& log,
      Pipes pipes);
  /// Kills what still runs.
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;

  /// Whole lines that it has written since the last call, of about the next `most` bytes; never
  /// waits. One longer than kLongestLine is lost. The last one needs no end.
  [[nodiscard]] std::vector<std::string> lines(std::size_t most = kLongestLine);
  /// A line to its input; what it does not read in time is lost with it.
  void write_line(const std::string& line);
  void close_input();

  /// Its exit code once it has ended, negative after a signal.
  [[nodiscard]] std::optional<int> ended();
  /// Waits for its end; false when that has not come in time.
  [[nodiscard]] bool wait(std::chrono::milliseconds time);
  void signal(int number) const;
  [[nodiscard]] pid_t pid() const { return pid_; }
  /// SIGTERM to its group, SIGKILL when it is still there after `time`.
  void stop(std::chrono::milliseconds time);

 private:
  ChildProcess() = default;
  pid_t pid_ = -1;
  int input_ = -1, output_ = -1;
  std::string pending_;
  std::optional<int> exit_code_;
};

}  // namespace aprsim::process
