#include "world/base/process/child_process.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <linux/close_range.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>

extern char** environ;

namespace aprsim::process {
namespace {

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> out;
  for (auto& text : texts) out.push_back(text.data());
  out.push_back(nullptr);
  return out;
}

std::vector<std::string> with_environment(
    const std::vector<std::pair<std::string, std::string>>& added) {
  std::vector<std::string> out;
  for (const auto& [name, value] : added) out.push_back(name + '=' + value);
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text(*entry);
    bool is_added = false;
    for (const auto& [name, value] : added) is_added |= text.starts_with(name + '=');
    if (!is_added) out.emplace_back(text);
  }
  return out;
}

void close_fd(int& fd) {
  if (fd >= 0) close(fd);
  fd = -1;
}

/// Marks all files but standard input, output and error as close-on-exec.
void close_files_at_exec() {
  if (close_range(3, ~0U, CLOSE_RANGE_CLOEXEC) == 0) return;
  constexpr int kMost = 65536;
  for (int fd = 3; fd < kMost; ++fd) fcntl(fd, F_SETFD, FD_CLOEXEC);
}

/// Restores the default signal mask and dispositions for the program.
void restore_signals() {
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  std::signal(SIGPIPE, SIG_DFL);
}

}  // namespace

Result<ChildProcess> ChildProcess::start(
    const std::vector<std::string>& arguments,
    const std::vector<std::pair<std::string, std::string>>& environment, const std::string& log,
    Pipes pipes) {
  std::vector<std::string> texts = arguments, variables = with_environment(environment);
  const std::vector<char*> argv = pointers(texts), envp = pointers(variables);
  const bool talks = pipes == Pipes::kInputAndOutput;
  const bool tells = pipes == Pipes::kOutputAndErrors;
  const char* const log_file = tells ? "/dev/null" : log.c_str();
  const int log_fd = open(log_file, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  const int null_fd = open("/dev/null", O_RDONLY | O_CLOEXEC);
  std::array<int, 2> in{-1, -1}, out{-1, -1}, failure{-1, -1};
  const bool ready =
      log_fd >= 0 && null_fd >= 0 && pipe2(failure.data(), O_CLOEXEC) == 0 &&
      (!talks || socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, in.data()) == 0) &&
      (!(talks || tells) || pipe2(out.data(), O_CLOEXEC) == 0);
  const pid_t parent = getpid();
  const pid_t pid = ready ? fork() : -1;
  if (pid == 0) {
    // Only async-signal-safe calls are allowed between fork and exec.
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(127);
    restore_signals();
    dup2(talks ? in[0] : null_fd, STDIN_FILENO);
    dup2(talks || tells ? out[1] : log_fd, STDOUT_FILENO);
    dup2(tells ? out[1] : log_fd, STDERR_FILENO);
    close_files_at_exec();
    execvpe(argv[0], argv.data(), envp.data());
    const int error = errno;
    [[maybe_unused]] const ssize_t told = write(failure[1], &error, sizeof error);
    _exit(127);
  }
  int error = pid < 0 ? errno : 0;
  for (int fd : {log_fd, null_fd, in[0], out[1], failure[1]}) close_fd(fd);
  if (pid > 0 && read(failure[0], &error, sizeof error) == sizeof error) {
    waitpid(pid, nullptr, 0);
  }
  close_fd(failure[0]);
  if (error != 0) {
    for (int fd : {in[1], out[0]}) close_fd(fd);
    return fail(ErrorCode::kNotFound, "program",
                "cannot start " + arguments[0] + ": " + std::strerror(error));
  }
  ChildProcess child;
  child.pid_ = pid;
  child.input_ = in[1];
  child.output_ = out[0];
  for (const int fd : {child.input_, child.output_}) {
    if (fd >= 0) fcntl(fd, F_SETFL, O_NONBLOCK);
  }
  return child;
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      input_(std::exchange(other.input_, -1)),
      output_(std::exchange(other.output_, -1)),
      pending_(std::move(other.pending_)),
      exit_code_(other.exit_code_) {}

ChildProcess::~ChildProcess() {
  close_fd(input_);
  close_fd(output_);
  if (pid_ <= 0 || ended()) return;
  signal(SIGKILL);
  waitpid(pid_, nullptr, 0);
}

std::vector<std::string> ChildProcess::lines(std::size_t most) {
  std::array<char, 4096> buffer{};
  for (std::size_t taken = 0; output_ >= 0 && taken < most;) {
    const ssize_t size = read(output_, buffer.data(), buffer.size());
    if (size < 0) break;
    if (size == 0) {
      close_fd(output_);
      if (!pending_.empty() && pending_.back() != '\n') pending_ += '\n';
      break;
    }
    pending_.append(buffer.data(), static_cast<std::size_t>(size));
    taken += static_cast<std::size_t>(size);
  }
  std::vector<std::string> out;
  std::size_t begin = 0;
  for (std::size_t end = 0; (end = pending_.find('\n', begin)) != std::string::npos;) {
    out.push_back(pending_.substr(begin, end - begin));
    begin = end + 1;
  }
  pending_.erase(0, begin);
  if (pending_.size() > kLongestLine) pending_.clear();
  return out;
}

void ChildProcess::write_line(const std::string& line) {
  if (input_ < 0) return;
  const std::string text = line + '\n';
  // A socket, not a pipe: writing after the reader closed it raises no SIGPIPE (MSG_NOSIGNAL). Its
  // buffer holds far more than a line.
  if (send(input_, text.data(), text.size(), MSG_NOSIGNAL) < 0 && errno == EPIPE) close_fd(input_);
}

void ChildProcess::close_input() { close_fd(input_); }

std::optional<int> ChildProcess::ended() {
  int status = 0;
  if (!exit_code_ && pid_ > 0 && waitpid(pid_, &status, WNOHANG) == pid_) {
    exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  return exit_code_;
}

bool ChildProcess::wait(std::chrono::milliseconds time) {
  const auto deadline = std::chrono::steady_clock::now() + time;
  while (!ended()) {
    if (std::chrono::steady_clock::now() >= deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

void ChildProcess::signal(int number) const {
  if (pid_ > 0 && !exit_code_) kill(-pid_, number);
}

void ChildProcess::stop(std::chrono::milliseconds time) {
  signal(SIGTERM);
  if (wait(time)) return;
  signal(SIGKILL);
  static_cast<void>(wait(time));
}

}  // namespace aprsim::process
