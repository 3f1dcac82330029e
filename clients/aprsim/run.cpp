#include "clients/aprsim/run.hpp"

#include <cerrno>
#include <cstring>
#include <ostream>
#include <utility>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/cli/exit_code.hpp"
#include "clients/aprsim/cli/interruption.hpp"
#include "clients/aprsim/commands/command_line.hpp"
#include "world/base/process/input_end.hpp"
#include "world/base/utf8.hpp"

namespace aprsim::client {
namespace {

int report(const Failure& failure, std::ostream& err, const Paint& paint) {
  // The message may quote a peer or a file.
  err << paint(Tone::kBad, "aprsim:") << ' ' << utf8::printable(failure.message, "\n\t");
  if (failure.kind == FailureKind::kUnauthenticated) {
    err << " (--token-file FILE, or the variable APRSIM_TOKEN)";
  }
  err << '\n';
  return exit_code(failure.kind);
}

/// The failure of an output that could not be written; it must not pass for success.
int report_output(int error, std::ostream& err, const Paint& paint) {
  const std::string cause = error != 0 ? std::string(": ") + std::strerror(error) : "";
  return report({FailureKind::kCheck, "cannot write the output" + cause}, err, paint);
}

/// Whether the command needs the endpoints of a running daemon, or the files of its encryption.
bool needs_cell(const AnyCommand& command) {
  if (const auto* run = std::get_if<ScenarioRunCommand>(&command)) return run->attach;
  if (const auto* crcl = std::get_if<ConformCrclCommand>(&command)) return crcl->address.empty();
  if (const auto* modbus = std::get_if<ConformModbusCommand>(&command)) {
    return modbus->address.empty() || !modbus->server.empty() || modbus->secure;
  }
  return !std::holds_alternative<CompletionCommand>(command) &&
         !std::holds_alternative<ManualCommand>(command) &&
         !std::holds_alternative<CrclValidateCommand>(command) &&
         !std::holds_alternative<FaultKindsCommand>(command) &&
         !std::holds_alternative<ConformClausesCommand>(command) &&
         !std::holds_alternative<ScenarioListCommand>(command) &&
         !std::holds_alternative<ScenarioCheckCommand>(command) &&
         !std::holds_alternative<SceneCheckCommand>(command) &&
         !std::holds_alternative<FileDiffCommand>(command) &&
         !std::holds_alternative<FileFormatCommand>(command) &&
         !std::holds_alternative<FileSchemaCommand>(command) &&
         !std::holds_alternative<BatchCommand>(command) &&
         !std::holds_alternative<MergeCommand>(command) &&
         !std::holds_alternative<ReportDiffCommand>(command) &&
         !std::holds_alternative<ReplayCommand>(command) &&
         !std::holds_alternative<TraceDiffCommand>(command) &&
         !std::holds_alternative<TraceExportCommand>(command) &&
         !std::holds_alternative<TraceImportCommand>(command) &&
         !std::holds_alternative<TraceShowCommand>(command) &&
         !std::holds_alternative<ConveyorMapCommand>(command);
}

}  // namespace

int run(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err,
        const Screen& screen) {
  const auto line = parse_command_line(arguments);
  if (!line) {
    if (line.error().exit_code != 0) {
      err << screen.err(Tone::kBad, "aprsim:") << ' ' << utf8::printable(line.error().text, "\n");
      return line.error().exit_code;
    }
    errno = 0;
    out << line.error().text << std::flush;
    return out.good() ? 0 : report_output(errno, err, screen.err);
  }
  if (line->exit_on_stdin_eof) process::stop_when_input_ends();
  auto endpoints = needs_cell(line->command) ? find_endpoints(line->endpoints) : Endpoints();
  if (!endpoints) return report(endpoints.error(), err, screen.err);
  Console console{std::move(*endpoints), ports_file_of(line->endpoints), out, line->json, screen};
  const auto done =
      std::visit([&](const auto& command) { return run_command(command, console); }, line->command);
  console.write("");
  int code = done ? 0 : report(done.error(), err, screen.err);
  if (!out.good()) {
    const int output_code = report_output(console.output_error, err, screen.err);
    if (code == 0) code = output_code;
  }
  return interruption::happened() ? interruption::kExitCode : code;
}

}  // namespace aprsim::client
