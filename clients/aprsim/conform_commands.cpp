#include <charconv>
#include <ostream>
#include <string>

#include <fmt/format.h>

#include "clients/aprsim/commands.hpp"
#include "clients/aprsim/conform/check.hpp"

namespace aprsim::client {
namespace {

using conform::Target;

// "HOST:PORT" or "[ADDRESS]:PORT".
Outcome<Target> target_of(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  std::uint16_t port = 0;
  const char* end = address.data() + address.size();
  const bool complete =
      colon != std::string::npos && colon > 0 &&
      std::from_chars(address.data() + colon + 1, end, port) == std::from_chars_result{end, {}} &&
      port != 0;
  if (!complete) {
    return failed(FailureKind::kUsage, fmt::format("'{}' is not HOST:PORT", address));
  }
  std::string host = address.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  return Target{host, port};
}

}  // namespace

Outcome<void> run_command(const ConformCrclCommand& command, Console& console) {
  Outcome<Target> target;
  if (command.address.empty()) {
    const auto port = crcl_port(console.endpoints, command.robot);
    if (!port) return tl::unexpected(port.error());
    target = Target{console.endpoints.host, *port};
  } else {
    target = target_of(command.address);
  }
  if (!target) return tl::unexpected(target.error());
  target->allow_motion = command.allow_motion;
  return conform::check_server(conform::crcl_checks(), *target, console);
}

Outcome<void> run_command(const ConformModbusCommand& command, Console& console) {
  Outcome<Target> target = command.address.empty()
                               ? Target{console.endpoints.host, console.endpoints.modbus}
                               : target_of(command.address);
  if (!target) return tl::unexpected(target.error());
  target->allow_motion = command.allow_motion;
  return conform::check_server(conform::modbus_checks(), *target, console);
}

Outcome<void> run_command(const ConformClausesCommand& /*command*/, Console& console) {
  console.out << conform::clauses_page("A robot's CRCL server", conform::crcl_checks()) << '\n'
              << conform::clauses_page("The conveyor's Modbus server", conform::modbus_checks());
  return {};
}

}  // namespace aprsim::client
