#include "tests/support/terminal_process.hpp"

#include <array>
#include <csignal>
#include <poll.h>
#include <pty.h>
#include <stdexcept>
#include <string_view>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/patience.hpp"

extern char** environ;

namespace aprsim::test {
namespace {

using Clock = std::chrono::steady_clock;

std::string_view name_of(std::string_view variable) {
  return variable.substr(0, variable.find('='));
}

std::vector<std::string> environment_with(const std::vector<std::string>& changes) {
  std::vector<std::string> out;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    bool changed = false;
    for (const auto& change : changes) changed |= name_of(change) == name_of(*variable);
    if (!changed) out.emplace_back(*variable);
  }
  for (const auto& change : changes) {
    if (change.find('=') != std::string::npos) out.push_back(change);
  }
  return out;
}

std::vector<char*> pointers(const std::vector<std::string>& texts) {
  std::vector<char*> out;
  for (const auto& text : texts) out.push_back(const_cast<char*>(text.c_str()));
  out.push_back(nullptr);
  return out;
}

}  // namespace

TerminalProcess::TerminalProcess(const std::vector<std::string>& argv,
                                 const std::vector<std::string>& environment) {
  const auto variables = environment_with(environment);
  const auto arguments = pointers(argv);
  const auto variable_pointers = pointers(variables);
  winsize size{};
  size.ws_row = 24;
  size.ws_col = 100;
  pid_ = forkpty(&terminal_, nullptr, nullptr, &size);
  if (pid_ < 0) throw std::runtime_error("no terminal");
  if (pid_ == 0) {
    execvpe(arguments[0], arguments.data(), variable_pointers.data());
    _exit(127);
  }
}

TerminalProcess::~TerminalProcess() {
  if (!ended_) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  close(terminal_);
}

void TerminalProcess::type(const std::string& keys) {
  if (write(terminal_, keys.data(), keys.size()) != static_cast<ssize_t>(keys.size())) {
    throw std::runtime_error("the terminal takes no keys");
  }
}

void TerminalProcess::send(int signal) const { kill(pid_, signal); }

void TerminalProcess::read_some() {
  pollfd waiting{terminal_, POLLIN, 0};
  if (poll(&waiting, 1, 10) <= 0) return;
  std::array<char, 4096> buffer{};
  const ssize_t size = read(terminal_, buffer.data(), buffer.size());
  if (size > 0) {
    output_.append(buffer.data(), static_cast<std::size_t>(size));
  } else {
    usleep(2000);  // the other end is closed: no waiting there
  }
}

void TerminalProcess::wait_for(const std::string& text, Seconds deadline) {
  const auto end = Clock::now() + kPatience * deadline;
  while (true) {
    const std::size_t found = output_.find(text, seen_);
    if (found != std::string::npos) {
      seen_ = found + text.size();
      return;
    }
    if (Clock::now() > end) give_up("waited in vain for '" + text + "'");
    read_some();
  }
}

bool TerminalProcess::has_ended() {
  int status = 0;
  if (!ended_ && waitpid(pid_, &status, WNOHANG) == pid_) {
    ended_ = true;
    exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    // Reads its last output.
    for (std::size_t before = output_.size() + 1; before != output_.size();) {
      before = output_.size();
      read_some();
    }
  }
  return ended_;
}

int TerminalProcess::wait_for_exit(Seconds deadline) {
  const auto end = Clock::now() + kPatience * deadline;
  while (!has_ended()) {
    if (Clock::now() > end) give_up("does not end");
    read_some();
  }
  return exit_code_;
}

void TerminalProcess::give_up(const std::string& what) const {
  throw std::runtime_error(what + "; the terminal shows:\n" + output_);
}

}  // namespace aprsim::test
