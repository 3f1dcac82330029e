#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <sys/types.h>
#include <vector>

#include "tests/support/temporary_directory.hpp"

namespace aprsim::test {

/// Result of a finished process: exit code (negative = killed by that signal) and its output.
struct ProcessResult {
  int exit_code = 0;
  std::string out;
  std::string err;
  std::chrono::milliseconds took{};
};

/// Runs a program to its end. Throws std::runtime_error after `deadline`, having killed it.
ProcessResult run_process(const std::vector<std::string>& argv,
                          std::chrono::seconds deadline = std::chrono::seconds(30));

/// The real daemon on free ports, for one test.
class DaemonProcess {
 public:
  /// Starts it with `arguments` besides --any-port and --ports-file, and waits until it serves.
  /// Throws std::runtime_error with its log when it does not within a minute. `log`: a
  /// descriptor for its log, which else goes into a file.
  explicit DaemonProcess(std::vector<std::string> arguments = {}, int log = -1);
  /// Kills what still runs.
  ~DaemonProcess();
  DaemonProcess(const DaemonProcess&) = delete;
  DaemonProcess& operator=(const DaemonProcess&) = delete;

  /// Port of "crcl.fanuc", "modbus", "grpc", ...; throws std::out_of_range.
  [[nodiscard]] std::uint16_t port(const std::string& name) const { return ports_.at(name); }
  [[nodiscard]] const std::string& ports_file() const { return ports_file_; }
  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] const std::map<std::string, std::uint16_t>& ports() const { return ports_; }
  /// Its log so far.
  [[nodiscard]] std::string log() const;

  /// Sends a signal and waits for the end.
  ProcessResult stop(int signal);

 private:
  void read_ports();

  TemporaryDirectory directory_;
  std::string ports_file_;
  pid_t pid_ = -1;
  std::map<std::string, std::uint16_t> ports_;
};

}  // namespace aprsim::test
