// The daemon as a process among others: inherited signals, closed descriptors, full disks.

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/daemon_process.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;

const std::string kDaemonPath = std::string(APRSIM_BIN_DIR) + "/aprsimd";

/// A daemon that a shell command starts.
class ShellDaemon {
 public:
  /// `command` uses $DAEMON, which listens on free ports, and ends in `exec $DAEMON ...`.
  explicit ShellDaemon(const std::string& command) {
    const std::string daemon =
        kDaemonPath + " --any-port --no-web --speed stepped --ports-file " + ports_file();
    pid_ = ::fork();
    if (pid_ == 0) {
      ::setenv("DAEMON", daemon.c_str(), 1);
      ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
      ::_exit(127);
    }
    EXPECT_TRUE(eventually([&] { return std::filesystem::exists(ports_file()); }, 60s));
  }
  ~ShellDaemon() {
    if (pid_ < 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  ShellDaemon(const ShellDaemon&) = delete;
  ShellDaemon& operator=(const ShellDaemon&) = delete;

  [[nodiscard]] std::string path(const std::string& name) const {
    return directory_.path() + '/' + name;
  }
  [[nodiscard]] std::string ports_file() const { return path("ports.json"); }
  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] std::string target_of(int descriptor) const {
    return std::filesystem::read_symlink("/proc/" + std::to_string(pid_) + "/fd/" +
                                         std::to_string(descriptor));
  }
  /// Sends SIGTERM; the exit code.
  int stop() {
    ::kill(pid_, SIGTERM);
    int status = 0;
    ::waitpid(std::exchange(pid_, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  TemporaryDirectory directory_;
  pid_t pid_ = -1;
};

/// The signals that /proc tells as ignored, or as pending and blocked.
bool signal_in(pid_t pid, const std::string& set, int signal) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (!line.starts_with(set + ":")) continue;
    return (std::stoull(line.substr(set.size() + 1), nullptr, 16) >> (signal - 1) & 1U) != 0;
  }
  return false;
}

TEST(DaemonAsAProcess, LetsSignalsThatItInheritedAsIgnoredPass) {
  ShellDaemon daemon("trap '' HUP INT; exec $DAEMON");
  for (const int signal : {SIGHUP, SIGINT}) {
    EXPECT_FALSE(signal_in(daemon.pid(), "SigBlk", signal)) << signal;
    EXPECT_TRUE(signal_in(daemon.pid(), "SigIgn", signal)) << signal;
    ::kill(daemon.pid(), signal);
  }
  // An ignored signal is gone at once, so the next one that counts is this.
  EXPECT_EQ(daemon.stop(), 0);
}

TEST(DaemonAsAProcess, LogsNowhereElseWhereStandardErrorIsClosed) {
  for (const std::string closed : {"2>&-", "1>&- 2>&-", "0<&- 1>&- 2>&-"}) {
    const TemporaryDirectory directory;
    const std::string audit = directory.path() + "/audit";
    ShellDaemon daemon("exec $DAEMON --set access.audit_file=" + audit + " " + closed);
    EXPECT_EQ(daemon.target_of(2), "/dev/null") << closed;
    EXPECT_EQ(daemon.stop(), 0) << closed;
    std::ifstream lines(audit);
    for (std::string line; std::getline(lines, line);) {
      EXPECT_TRUE(nlohmann::json::accept(line)) << closed << ": " << line;
    }
  }
}

TEST(DaemonAsAProcess, SaysWhenItsOutputCannotBeWritten) {
  for (const std::string command :
       {"--print-config", "--list-keys", "--check", "--help", "--version", "token --help"}) {
    for (const std::string where : {">/dev/full", ">&-"}) {
      const auto result = run_process({"/bin/sh", "-c", kDaemonPath + ' ' + command + where});
      EXPECT_EQ(result.exit_code, 1) << command << where;
      EXPECT_NE(result.err.find("cannot write the output"), std::string::npos)
          << command << where << ": " << result.err;
    }
  }
}

TEST(DaemonAsAProcess, SuggestsOptionsForMistypedOnes) {
  const auto result = run_process({kDaemonPath, "--print-confg"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("did you mean '--print-config'?"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace aprsim::test
