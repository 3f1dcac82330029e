#include "clients/aprsim/run.hpp"

#include <ostream>
#include <utility>

#include "clients/aprsim/commands.hpp"

namespace aprsim::client {
namespace {

int report(const Failure& failure, std::ostream& err) {
  err << "aprsim: " << failure.message << '\n';
  switch (failure.kind) {
    case FailureKind::kUsage:
      return 2;
    case FailureKind::kConnection:
      return 3;
    case FailureKind::kTimeout:
      return 4;
    case FailureKind::kRefused:
    case FailureKind::kCheck:
      break;
  }
  return 1;
}

}  // namespace

int run(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err) {
  const auto line = parse_command_line(arguments);
  if (!line) {
    (line.error().exit_code == 0 ? out : err) << line.error().text;
    return line.error().exit_code;
  }
  auto endpoints = find_endpoints(line->endpoints);
  if (!endpoints) return report(endpoints.error(), err);
  Console console{std::move(*endpoints), out};
  const auto done =
      std::visit([&](const auto& command) { return run_command(command, console); }, line->command);
  out.flush();
  return done ? 0 : report(done.error(), err);
}

}  // namespace aprsim::client
