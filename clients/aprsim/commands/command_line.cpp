#include "clients/aprsim/commands/command_line.hpp"

#include <algorithm>
#include <sstream>

#include <CLI/CLI.hpp>

#include "clients/aprsim/cli/command_tree.hpp"
#include "clients/aprsim/cli/exit_code.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "world/base/usage/usage_error.hpp"

namespace aprsim::client {
namespace {

constexpr int kUsageError = 2;

void set_crcl_port(EndpointChoice& choice, const std::string& text) {
  const auto [robot, number] = named_number_of(text);
  const auto port = port_of(number);
  if (robot.empty() || !port) {
    throw CLI::ValidationError("--crcl-port", "'" + text + "' is not ROBOT=PORT");
  }
  choice.crcl[robot] = *port;
}

void add_endpoints(CLI::App& app, EndpointChoice& choice) {
  app.add_option("--ports-file", choice.ports_file,
                 "Ports file written by aprsimd (default: $APRSIM_PORTS_FILE)")
      ->type_name("FILE")
      ->check(not_empty());
  app.add_option("--host", choice.host, "Host of the daemon (default 127.0.0.1)")
      ->type_name("HOST")
      ->check(not_empty());
  app.add_option("--token-file", choice.token_file,
                 "File whose first line is the daemon's access token (default: $APRSIM_TOKEN)")
      ->type_name("FILE")
      ->check(not_empty());
  app.add_flag("--tls", choice.tls, "Encrypt gRPC; trust the system's certificate authorities");
  for (const auto& [name, file, help] :
       {std::tuple("--ca", &choice.ca,
                   "PEM file of the certificate authorities of the daemon; implies --tls "
                   "(default: $APRSIM_CA)"),
        std::tuple("--certificate", &choice.certificate,
                   "PEM file of this client's certificate (default: $APRSIM_CERTIFICATE)"),
        std::tuple("--key", &choice.key, "PEM file of its private key (default: $APRSIM_KEY)")}) {
    app.add_option(name, *file, help)->type_name("FILE")->check(not_empty());
  }
  for (const auto& [name, port, help] :
       {std::tuple("--grpc-port", &choice.grpc, "gRPC port (default 50051)"),
        std::tuple("--modbus-port", &choice.modbus,
                   "Modbus port (default 1502, with --secure 802)")}) {
    app.add_option(name, *port, help)->type_name("PORT")->check(within(1, 65535));
  }
  app.add_option_function<std::vector<std::string>>(
         "--crcl-port",
         [&choice](const std::vector<std::string>& all) {
           for (const auto& one : all) set_crcl_port(choice, one);
         },
         "CRCL port as ROBOT=PORT (default fanuc=64444, motoman=64445)")
      ->type_name("ROBOT=PORT")
      ->allow_extra_args(false);
}

void add_all(CLI::App& app, CommandLine& line) {
  app.description("Client of the simulated kitting cell aprsimd");
  app.name("aprsim");
  app.require_subcommand(1);
  app.fallthrough();
  std::string exit_codes = "\nExit codes:\n";
  for (const auto& exit : kExitCodes) {
    exit_codes += "  " + std::to_string(exit.code) + "  " + std::string(exit.meaning) + "\n";
  }
  app.footer(exit_codes);
  app.set_version_flag("--version", APRSIM_VERSION, "Show the version");
  app.set_help_flag("-h,--help", "Show this help");
  app.add_flag("--json", line.json, "Print results as JSON, one object a line");
  add_endpoints(app, line.endpoints);
  app.add_flag("--exit-on-stdin-eof", line.exit_on_stdin_eof,
               "Stop when standard input ends, for example when the parent process exits");
  add_status(app, line);
  add_events(app, line);
  add_demo(app, line);
  add_crcl(app, line);
  add_conveyor(app, line);
  add_modbus(app, line);
  add_conform(app, line);
  add_simulation(app, line);
  add_states(app, line);
  add_replay(app, line);
  add_incident(app, line);
  add_scene(app, line);
  add_camera(app, line);
  add_intruder(app, line);
  add_device(app, line);
  add_fault(app, line);
  add_scenario(app, line);
  add_trace(app, line);
  add_batch(app, line);
  add_calibration(app, line);
  add_documents(app, line);
}

/// Description of one option for --help and the manual.
OptionInfo option_info(const CLI::Option& option) {
  OptionInfo info;
  for (const auto& name : option.get_snames()) info.names.push_back("-" + name);
  for (const auto& name : option.get_lnames()) info.names.push_back("--" + name);
  info.positional = option.get_positional();
  if (option.get_items_expected_max() > 0) {
    info.value = option.get_type_name();
    if (info.positional && info.value.find('|') == std::string::npos) {
      info.value = option.get_name(/*positional=*/true);
    }
  }
  info.required = option.get_required();
  info.help = option.get_description();
  return info;
}

/// Whether a command prints a document for which there is no JSON.
bool prints_document(const AnyCommand& command) {
  const auto* kinds = std::get_if<FaultKindsCommand>(&command);
  return std::holds_alternative<CompletionCommand>(command) ||
         std::holds_alternative<ManualCommand>(command) ||
         std::holds_alternative<ConformClausesCommand>(command) ||
         (kinds != nullptr && kinds->markdown);
}

CommandInfo command_info(const CLI::App& app, const std::string& path) {
  CommandInfo info{app.get_name(), path + app.get_name(), app.get_description(), {}, {}};
  for (const auto* option : app.get_options()) info.options.push_back(option_info(*option));
  for (const auto* sub : app.get_subcommands(nullptr)) {
    info.commands.push_back(command_info(*sub, info.path + " "));
  }
  return info;
}

}  // namespace

CommandInfo command_tree() {
  CommandLine line;
  CLI::App app;
  add_all(app, line);
  return command_info(app, "");
}

tl::expected<CommandLine, NoCommand> parse_command_line(std::vector<std::string> arguments) {
  CommandLine line;
  CLI::App app;
  add_all(app, line);
  try {
    std::ranges::reverse(arguments);
    app.parse(std::move(arguments));
  } catch (const CLI::ParseError& error) {
    std::ostringstream out, err;
    const int code = app.exit(error, out, err);
    if (code == 0) return tl::unexpected(NoCommand{0, out.str()});
    return tl::unexpected(NoCommand{kUsageError, usage::usage_error(app, error)});
  }
  if (line.json && prints_document(line.command)) {
    return tl::unexpected(
        NoCommand{kUsageError, "--json: this command prints a document, which has no JSON form\n"});
  }
  return line;
}

}  // namespace aprsim::client
