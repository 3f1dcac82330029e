#pragma once

#include <chrono>
#include <string>
#include <sys/types.h>
#include <vector>

namespace aprsim::test {

/// A program on a terminal of its own, of 24 lines and 100 columns: what a user types and sees.
class TerminalProcess {
 public:
  using Seconds = std::chrono::seconds;

  /// Starts it with further variables of the environment, each NAME=VALUE; NAME alone takes one
  /// away.
  explicit TerminalProcess(const std::vector<std::string>& argv,
                           const std::vector<std::string>& environment = {});
  /// Kills what still runs.
  ~TerminalProcess();
  TerminalProcess(const TerminalProcess&) = delete;
  TerminalProcess& operator=(const TerminalProcess&) = delete;

  /// Types; "\x03" is Ctrl-C.
  void type(const std::string& keys);
  void send(int signal) const;

  /// Waits until the text has come after all that was waited for before; throws std::runtime_error
  /// with the output at the deadline.
  void wait_for(const std::string& text, Seconds deadline = Seconds(20));
  /// Waits for the end; the exit code, negative = killed by that signal. Throws at the deadline.
  int wait_for_exit(Seconds deadline = Seconds(20));
  /// Whether it has ended by now.
  bool has_ended();

  /// All that it has written so far, both outputs.
  [[nodiscard]] const std::string& output() const { return output_; }
  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  /// Reads what is there; waits for a little while if that is nothing.
  void read_some();
  [[noreturn]] void give_up(const std::string& what) const;

  pid_t pid_ = -1;
  int terminal_ = -1;
  std::string output_;
  std::size_t seen_ = 0;  // of the output, by wait_for
  bool ended_ = false;
  int exit_code_ = 0;
};

}  // namespace aprsim::test
