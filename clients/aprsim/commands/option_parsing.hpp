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

/// Helpers with which the groups of commands declare their words and options.
namespace aprsim::client {

/// Declares a command whose parser fills the struct and selects it.
template <typename Command>
std::pair<CLI::App*, std::shared_ptr<Command>> add_command(CLI::App& app, CommandLine& line,
                                                           const char* name, const char* help) {
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand(name, help);
  sub->callback([&line, command] { line.command = *command; });
  sub->footer("\nAddresses of the daemon and exit codes: aprsim --help, aprsim manual");
  return {sub, command};
}

/// Declares --json.
void offer_json(CLI::App& sub, CommandLine& line, const char* what = "One JSON object a line");
/// Declares the required --robot.
CLI::Option* add_robot(CLI::App& sub, std::string& robot);
void add_timeout(CLI::App& sub, double& timeout_s, const char* what);

/// Declares --patience of runs in virtual time.
void add_patience(CLI::App& sub, unsigned& patience_s);

/// Reads the whole text as a finite number.
[[nodiscard]] std::optional<double> number_of(std::string_view text);

/// Splits NAME=NUMBER; the number is absent if it is not one.
struct NamedNumber {
  std::string name;
  std::optional<double> number;
};
[[nodiscard]] NamedNumber named_number_of(const std::string& text);
/// Reads a port number; absent if it is not one.
[[nodiscard]] std::optional<std::uint16_t> port_of(const std::optional<double>& number);
/// Reads a speed factor; absent for "max". Throws CLI::ValidationError for `option`.
[[nodiscard]] std::optional<double> factor_of(const char* option, const std::string& text);

/// A number within limits, both allowed; anything but a number is refused too.
[[nodiscard]] CLI::Validator within(double min, double max);
/// A number above 0 up to a limit.
[[nodiscard]] CLI::Validator above_zero(double max = std::numeric_limits<double>::max());
/// Neither NaN nor infinite.
[[nodiscard]] CLI::Validator finite();
/// Refuses an empty text: an unset shell variable must not select another file, host or robot.
[[nodiscard]] CLI::Validator not_empty();
/// One of several words, which help and completion show.
void choose(CLI::Option* option, const std::vector<std::string>& words);

}  // namespace aprsim::client
