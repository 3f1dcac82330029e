#include "clients/aprsim/commands/option_parsing.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <CLI/CLI.hpp>

#include "world/base/usage/suggestion.hpp"

namespace aprsim::client {

std::optional<double> number_of(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

NamedNumber named_number_of(const std::string& text) {
  const auto equals = text.find('=');
  return {text.substr(0, equals), equals == std::string::npos
                                      ? std::nullopt
                                      : number_of(std::string_view(text).substr(equals + 1))};
}

std::optional<std::uint16_t> port_of(const std::optional<double>& number) {
  constexpr double kMaxPort = 65535;
  if (!number || *number != std::floor(*number) || *number < 1 || *number > kMaxPort) {
    return std::nullopt;
  }
  return static_cast<std::uint16_t>(*number);
}

CLI::Validator within(double min, double max) {
  return CLI::Validator(
      [min, max](std::string& text) {
        const auto value = number_of(text);
        if (value && *value >= min && *value <= max) return std::string();
        return "'" + text + "' is not within " + CLI::detail::to_string(min) + " and " +
               CLI::detail::to_string(max);
      },
      "");
}

CLI::Validator above_zero(double max) {
  return CLI::Validator(
      [max](std::string& text) {
        const auto value = number_of(text);
        if (!value || *value <= 0) return "'" + text + "' is not a number above 0";
        return *value <= max ? std::string()
                             : "'" + text + "' is more than " + CLI::detail::to_string(max);
      },
      "");
}

CLI::Validator finite() {
  return CLI::Validator(
      [](std::string& text) {
        return number_of(text) ? std::string() : "'" + text + "' is not a finite number";
      },
      "");
}

CLI::Validator not_empty() {
  return CLI::Validator([](std::string& text) { return text.empty() ? "is empty" : std::string(); },
                        "");
}

void choose(CLI::Option* option, const std::vector<std::string>& words) {
  const std::string all = CLI::detail::join(words, "|");
  option->type_name(all)->check(CLI::Validator(
      [words, all](std::string& text) {
        return std::ranges::find(words, text) != words.end()
                   ? std::string()
                   : "'" + text + "' is not one of " + all + usage::suggestion(text, words);
      },
      ""));
}

std::optional<double> factor_of(const char* option, const std::string& text) {
  if (text == "max") return std::nullopt;
  const auto factor = number_of(text);
  if (!factor || *factor < 1e-3 || *factor > 1e6) {
    throw CLI::ValidationError(option, "'" + text + "' is neither within 0.001 and 1e6 nor 'max'");
  }
  return factor;
}

void offer_json(CLI::App& sub, CommandLine& line, const char* what) {
  sub.add_flag("--json", line.json, what);
}

CLI::Option* add_robot(CLI::App& sub, std::string& robot) {
  return sub.add_option("--robot", robot, "Name of the robot")
      ->type_name("ROBOT")
      ->check(not_empty())
      ->required();
}

void add_timeout(CLI::App& sub, double& timeout_s, const char* what) {
  constexpr double kMax = 1e6;
  sub.add_option("--timeout", timeout_s, what)->type_name("SECONDS")->check(above_zero(kMax));
}

void add_patience(CLI::App& sub, unsigned& patience_s) {
  // Within the hour that a single request may take.
  constexpr unsigned kMost_s = 3000;
  sub.add_option(
         "--patience", patience_s,
         "Give up a run in virtual time after this wall time without progress (default 600)")
      ->type_name("SECONDS")
      ->check(CLI::Range(1U, kMost_s).description(""));
}

}  // namespace aprsim::client
