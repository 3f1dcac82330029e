#include "clients/aprsim/commands/crcl_file_commands.hpp"

#include <fstream>
#include <iterator>
#include <ostream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/cli/interruption.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/text/crcl_text.hpp"
#include "clients/wires/crcl_session.hpp"
#include "crcl/command_codec.hpp"
#include "crcl/framer.hpp"
#include "crcl/program_loops.hpp"
#include "crcl/schema.hpp"

namespace aprsim::client {
namespace {

Outcome<std::string> read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return failed(FailureKind::kUsage, "cannot read " + path);
  return std::string(std::istreambuf_iterator<char>(in), {});
}

/// Number of valid documents of the text. Failure: the first invalid one.
Outcome<int> validate(const std::string& text) {
  constexpr std::size_t kLimit = crcl::kMaxProgramBytes;
  crcl::Framer framer(
      {{"CRCLCommandInstance", kLimit}, {"CRCLProgram", kLimit}, {"CRCLStatus", kLimit}});
  framer.append(text);
  int count = 0;
  while (true) {
    const auto document = framer.next();
    if (!document) return failed(FailureKind::kCheck, document.error().message());
    if (!*document) break;
    ++count;
    if (const auto fault = crcl::schema_fault(**document)) {
      return failed(FailureKind::kCheck, fmt::format("document {}: {}", count, fault->message()));
    }
  }
  if (framer.buffered() > 0 || count == 0) {
    return failed(FailureKind::kCheck,
                  fmt::format("document {} is not a complete CRCLCommandInstance, CRCLProgram or "
                              "CRCLStatus",
                              count + 1));
  }
  return count;
}

}  // namespace

Outcome<void> run_command(const CrclSendCommand& command, Console& console) {
  const auto text = read_file(command.file);
  if (!text) return tl::unexpected(text.error());
  const interruption::Hold hold;
  auto session = CrclSession::connect(console.endpoints, command.robot, interruption::requested);
  if (!session) return tl::unexpected(session.error());
  auto framer = crcl::Framer::for_commands();
  framer.append(*text);
  int count = 0;
  while (true) {
    auto document = framer.next();
    if (!document)
      return failed(FailureKind::kUsage, command.file + ": " + document.error().message());
    if (!*document) break;
    const auto instance = crcl::decode_command(**document);
    if (!instance)
      return failed(FailureKind::kUsage, command.file + ": " + instance.error().message());
    const auto& sent = instance->command;
    const auto status =
        session->run_document(**document, sent, CrclSession::Seconds(command.timeout_s));
    if (!status) return tl::unexpected(session->stopped_after(status.error()));
    console.show(fmt::format("{} {}: {}\n", crcl::type_name(sent.body), sent.id,
                             end_text(*status, console.screen.out)),
                 status_json(command.robot, *status));
    ++count;
  }
  if (count == 0)
    return failed(FailureKind::kUsage, command.file + " holds no CRCLCommandInstance");
  return {};
}

Outcome<void> run_command(const CrclRunCommand& command, Console& console) {
  const auto text = read_file(command.file);
  if (!text) return tl::unexpected(text.error());
  const auto program = crcl::decode_program(*text);
  if (!program) return failed(FailureKind::kUsage, command.file + ": " + program.error().message());
  const auto order = crcl::expand_loops(*program);
  if (!order) return failed(FailureKind::kUsage, command.file + ": " + order.error().message());
  const interruption::Hold hold;
  auto session = CrclSession::connect(console.endpoints, command.robot, interruption::requested);
  if (!session) return tl::unexpected(session.error());
  int index = 0;
  for (const std::size_t next : *order) {
    crcl::CommandInstance instance;
    instance.program_file = command.file;
    instance.program_index = index++;
    instance.program_length = static_cast<int>(order->size());
    instance.command = program->commands[next];
    if (!console.json) {
      console.print(fmt::format("{:>4}/{} {} ... ", index, order->size(),
                                crcl::type_name(instance.command.body)));
    }
    const auto status = session->run(std::move(instance), CrclSession::Seconds(command.timeout_s));
    if (!status) {
      if (!console.json) console.print("failed\n");
      return tl::unexpected(session->stopped_after(status.error()));
    }
    console.show(end_text(*status, console.screen.out) + "\n", status_json(command.robot, *status));
  }
  return {};
}

Outcome<void> run_command(const CrclValidateCommand& command, Console& console) {
  const auto text = read_file(command.file);
  if (!text) return tl::unexpected(text.error());
  const auto count = validate(*text);
  if (!count) return failed(count.error().kind, command.file + ": " + count.error().message);
  console.show(
      fmt::format("{}: {} valid document{}\n", command.file, *count, *count == 1 ? "" : "s"),
      {{"file", command.file}, {"valid_documents", *count}});
  return {};
}

void add_crcl_files(CLI::App& crcl, CommandLine& line) {
  auto [send, send_command] = add_command<CrclSendCommand>(
      crcl, line, "send", "Send the CRCLCommandInstance documents of a file, one after the other");
  send->add_option("FILE", send_command->file, "File of CRCLCommandInstance documents")->required();
  add_robot(*send, send_command->robot);
  add_timeout(*send, send_command->timeout_s, "Timeout of each command (default 120)");
  offer_json(*send, line);
  auto [run, run_command] =
      add_command<CrclRunCommand>(crcl, line, "run", "Run a CRCLProgram, one command at a time");
  run->add_option("FILE", run_command->file, "File of a CRCLProgram document")->required();
  add_robot(*run, run_command->robot);
  add_timeout(*run, run_command->timeout_s, "Timeout of each command (default 120)");
  offer_json(*run, line);
  auto [validate, validate_command] = add_command<CrclValidateCommand>(
      crcl, line, "validate", "Check the CRCL documents of a file against the schema");
  validate->add_option("FILE", validate_command->file, "CRCL documents")->required();
  offer_json(*validate, line);
}

}  // namespace aprsim::client
