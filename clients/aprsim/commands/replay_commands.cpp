#include "clients/aprsim/commands/replay_commands.hpp"

#include <chrono>
#include <cmath>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/cli/interruption.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "world/base/process/child_process.hpp"
#include "world/base/process/own_programs.hpp"

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

/// Reads a moment of a run in the syntax of aprsimd.
CLI::Validator moment() {
  return CLI::Validator(
      [](std::string& text) {
        const auto colon = text.find(':');
        const auto seconds = number_of(std::string_view(text).substr(colon + 1));
        const auto epoch = colon == std::string::npos ? 0 : number_of(text.substr(0, colon));
        const bool good =
            seconds && *seconds >= 0 && epoch && *epoch >= 0 && *epoch == std::floor(*epoch);
        return good ? std::string() : "'" + text + "' is neither SECONDS nor EPOCH:SECONDS";
      },
      "");
}

}  // namespace

Outcome<void> run_command(const ReplayCommand& command, Console& console) {
  const interruption::Hold hold;
  auto daemon = ChildProcess::start(daemon_line(command, console.json), {}, "/dev/null",
                                    ChildProcess::Pipes::kOutputAndErrors);
  if (!daemon) return failed(FailureKind::kUsage, daemon.error().message);
  const std::string own = "aprsimd: ";
  std::string complaint;  // error of aprsimd, reported as ours
  const auto show = [&] {
    for (const std::string& line : daemon->lines()) {
      if (line.starts_with(own)) {
        complaint = line.substr(own.size());
      } else {
        console.print(line + '\n');
      }
    }
  };
  std::optional<int> code;
  while (!(code = daemon->ended())) {
    show();
    if (interruption::requested()) {
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

void add_replay(CLI::App& app, CommandLine& line) {
  auto [replay, command] = add_command<ReplayCommand>(
      app, line, "replay", "Replay a recorded run and compare its states; needs no daemon");
  replay
      ->add_option("FILE", command->files,
                   "Journals of one run in order, the first one, or their directory")
      ->type_name("FILE|DIR ...")
      ->check(not_empty())
      ->required();
  replay
      ->add_option("--from", command->from,
                   "Start at the last checkpoint before this simulated time")
      ->type_name("[EPOCH:]SECONDS")
      ->check(moment());
  replay->add_option("--to", command->to, "Stop at this simulated time")
      ->type_name("[EPOCH:]SECONDS")
      ->check(moment());
  replay
      ->add_option_function<std::string>(
          "--speed",
          [c = command](const std::string& text) {
            static_cast<void>(factor_of("--speed", text));
            c->speed = text;
          },
          "Ratio of simulated to wall time, or max (default; with --serve 1)")
      ->type_name("X");
  replay->add_flag("--serve", command->serve,
                   "Serve the replay to browsers and gRPC clients, read-only");
  replay->add_flag("--any-port", command->any_port, "With --serve: listen on free ports")
      ->needs("--serve");
  replay
      ->add_option("--write-ports", command->ports_file,
                   "With --serve: write the ports as JSON to this file")
      ->type_name("FILE")
      ->needs("--serve");
  offer_json(*replay, line);
}

}  // namespace aprsim::client
