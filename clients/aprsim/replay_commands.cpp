#include <chrono>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "clients/aprsim/commands.hpp"
#include "clients/aprsim/interruption.hpp"
#include "clients/process/child_process.hpp"
#include "clients/process/own_programs.hpp"

namespace aprsim::client {
namespace {

using process::ChildProcess;
using std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLook{50}, kEnd{5000};

std::vector<std::string> daemon_line(const ReplayCommand& command, bool json) {
  std::vector<std::string> line = {process::program_beside("aprsimd")};
  for (const std::string& file : command.files) line.insert(line.end(), {"--replay", file});
  if (!command.from.empty()) line.insert(line.end(), {"--from", command.from});
  if (!command.to.empty()) line.insert(line.end(), {"--to", command.to});
  if (!command.speed.empty()) line.insert(line.end(), {"--speed", command.speed});
  if (command.serve) line.emplace_back("--serve");
  if (command.any_port) line.emplace_back("--any-port");
  if (!command.ports_file.empty()) line.insert(line.end(), {"--ports-file", command.ports_file});
  if (json) line.emplace_back("--json");
  return line;
}

}  // namespace

Outcome<void> run_command(const ReplayCommand& command, Console& console) {
  const interruption::Hold hold;
  auto daemon = ChildProcess::start(daemon_line(command, console.json), {}, "/dev/null",
                                    ChildProcess::Pipes::kOutputAndErrors);
  if (!daemon) return failed(FailureKind::kUsage, daemon.error().message);
  const std::string own = "aprsimd: ";
  std::string complaint;  // the daemon's, which is told as ours
  const auto show = [&] {
    for (const std::string& line : daemon->lines()) {
      if (line.starts_with(own)) {
        complaint = line.substr(own.size());
      } else {
        console.out << line << '\n' << std::flush;
      }
    }
  };
  std::optional<int> code;
  while (!(code = daemon->ended())) {
    show();
    if (interruption::noted()) {
      daemon->stop(kEnd);
      show();
      return failed(FailureKind::kInterrupted, "interrupted");
    }
    interruption::sleep_until(steady_clock::now() + kLook);
  }
  show();
  if (*code == 0) return {};
  if (complaint.empty()) complaint = *code == 1 ? "the run differs" : "the replay has failed";
  return failed(*code == 2 ? FailureKind::kUsage : FailureKind::kCheck, complaint);
}

}  // namespace aprsim::client
