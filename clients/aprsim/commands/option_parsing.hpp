#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "clients/aprsim/commands/command_line.hpp"

/// What the groups of commands declare their words and options with.
namespace aprsim::client {

/// The parser of one command: it fills the struct, and marks it as the chosen one.
template <typename Command>
std::pair<CLI::App*, std::shared_ptr<Command>> add_command(CLI::App& app, CommandLine& line,
                                                           const char* name, const char* help) {
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand(name, help);
  sub->callback([&line, command] { line.command = *command; });
  sub->footer("\nWhere the daemon is, and exit codes: aprsim --help, aprsim manual");
  return {sub, command};
}

/// Results as JSON.
void offer_json(CLI::App& sub, CommandLine& line, const char* what = "One JSON object a line");
/// A robot that must be named.
CLI::Option* add_robot(CLI::App& sub, std::string& robot);
void add_timeout(CLI::App& sub, double& timeout_s, const char* what);

/// The whole text as a finite number.
[[nodiscard]] std::optional<double> number_of(std::string_view text);

/// NAME=NUMBER; without a number where there is none.
struct NamedNumber {
  std::string name;
  std::optional<double> number;
};
[[nodiscard]] NamedNumber named_number_of(const std::string& text);
/// A number as that of a port; nothing when it is none.
[[nodiscard]] std::optional<std::uint16_t> port_of(const std::optional<double>& number);
/// Of a speed; nothing for max. Throws CLI::ValidationError for `option`.
[[nodiscard]] std::optional<double> factor_of(const char* option, const std::string& text);

/// A number within limits, both allowed; anything but a number is refused too.
[[nodiscard]] CLI::Validator within(double min, double max);
/// A number above 0 up to a limit.
[[nodiscard]] CLI::Validator above_zero(double max = std::numeric_limits<double>::max());
/// Neither NaN nor infinite.
[[nodiscard]] CLI::Validator finite();
/// A shell variable that is not set must not lead to another file, host or robot.
[[nodiscard]] CLI::Validator not_empty();
/// One of a few words; help and completion show them.
void choose(CLI::Option* option, const std::vector<std::string>& words);

}  // namespace aprsim::client
