#include "tests/support/daemon_process.hpp"

#include <csignal>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <spawn.h>
#include <sstream>
#include <stdexcept>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "tests/support/patience.hpp"

extern char** environ;

namespace aprsim::test {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

std::string slurp(const std::string& path) {
  std::ifstream in(path);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

pid_t spawn(const std::vector<std::string>& argv, const std::string& directory, int log = -1) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  const std::string out = directory + "/out";
  const std::string err = directory + "/err";
  posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, 1, out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (log >= 0) {
    posix_spawn_file_actions_adddup2(&files, log, 2);
  } else {
    posix_spawn_file_actions_addopen(&files, 2, err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  }
  std::vector<char*> args;
  for (const auto& arg : argv) args.push_back(const_cast<char*>(arg.c_str()));
  args.push_back(nullptr);
  pid_t pid = -1;
  const int error = posix_spawnp(&pid, args[0], &files, nullptr, args.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (error != 0) throw std::runtime_error("cannot start " + argv[0]);
  return pid;
}

/// Waits for the end of `pid`; false at the deadline.
bool wait_for_exit(pid_t pid, Clock::time_point deadline, int& status) {
  while (waitpid(pid, &status, WNOHANG) == 0) {
    if (Clock::now() > deadline) return false;
    std::this_thread::sleep_for(2ms);
  }
  return true;
}

int exit_code_of(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status); }

}  // namespace

ProcessResult run_process(const std::vector<std::string>& argv, std::chrono::seconds deadline) {
  const TemporaryDirectory directory;
  const auto start = Clock::now();
  const pid_t pid = spawn(argv, directory.path());
  int status = 0;
  const bool ended = wait_for_exit(pid, start + kPatience * deadline, status);
  if (!ended) {
    kill(pid, SIGKILL);
    waitpid(pid, &status, 0);
  }
  ProcessResult result{
      .exit_code = exit_code_of(status),
      .out = slurp(directory.path() + "/out"),
      .err = slurp(directory.path() + "/err"),
      .took = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - start)};
  if (!ended) {
    throw std::runtime_error(argv[0] + " did not end in time:\n" + result.out + result.err);
  }
  return result;
}

DaemonProcess::DaemonProcess(std::vector<std::string> arguments, int log)
    : ports_file_(directory_.path() + "/ports.json") {
  std::vector<std::string> argv = {std::string(APRSIM_BIN_DIR) + "/aprsimd", "--any-port",
                                   "--ports-file", ports_file_};
  argv.insert(argv.end(), arguments.begin(), arguments.end());
  pid_ = spawn(argv, directory_.path(), log);
  const auto deadline = Clock::now() + kPatience * 60s;
  int status = 0;
  while (!fs::exists(ports_file_)) {
    const bool ended = waitpid(pid_, &status, WNOHANG) == pid_;
    if (ended || Clock::now() > deadline) {
      const std::string said = slurp(directory_.path() + "/err");
      if (ended) pid_ = -1;
      throw std::runtime_error("the daemon does not serve:\n" + said);
    }
    std::this_thread::sleep_for(5ms);
  }
  read_ports();
}

DaemonProcess::~DaemonProcess() {
  if (pid_ > 0) {
    int status = 0;
    kill(pid_, SIGKILL);
    waitpid(pid_, &status, 0);
  }
}

void DaemonProcess::read_ports() {
  const auto json = nlohmann::json::parse(slurp(ports_file_));
  for (const auto& [name, value] : json.items()) {
    if (name != "pid") ports_[name] = value.get<std::uint16_t>();
  }
}

std::string DaemonProcess::log() const { return slurp(directory_.path() + "/err"); }

ProcessResult DaemonProcess::stop(int signal) {
  const auto start = Clock::now();
  kill(pid_, signal);
  int status = 0;
  if (!wait_for_exit(pid_, start + 10s, status)) throw std::runtime_error("the daemon hangs");
  pid_ = -1;
  return {.exit_code = exit_code_of(status),
          .out = slurp(directory_.path() + "/out"),
          .err = slurp(directory_.path() + "/err"),
          .took = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - start)};
}

}  // namespace aprsim::test
