#include "server/operations/usage_error.hpp"

#include <algorithm>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "world/base/yaml/yaml_reader.hpp"

namespace aprsim::server {
namespace {

using Names = std::vector<std::string>;

/// Longest argument that is compared with names.
constexpr std::size_t kLongestName = 64;

/// The last command that was recognized, or the program.
const CLI::App& recognized(const CLI::App& app) {
  const auto chosen = app.get_subcommands();
  return chosen.empty() ? app : recognized(*chosen.front());
}

Names option_names(const CLI::App& app) {
  Names names;
  for (const auto* option : app.get_options()) {
    for (const auto& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

Names command_names(const CLI::App& app) {
  Names names;
  for (const auto* command : app.get_subcommands(nullptr)) names.push_back(command->get_name());
  return names;
}

std::string suggestion(const std::string& word, const Names& known) {
  if (word.size() > kLongestName) return "";
  std::string near = yaml::nearest_word(word, known);
  if (near.empty() && word.size() > 3) {
    const auto longer = std::ranges::find_if(
        known, [&](const std::string& name) { return name.starts_with(word); });
    if (longer != known.end()) near = *longer;
  }
  return near.empty() ? "" : fmt::format("; did you mean '{}'?", near);
}

std::string unexpected_text(const std::string& argument, const CLI::App& command) {
  if (argument.starts_with("-")) {
    const std::string name = argument.substr(0, argument.find('='));
    return fmt::format("unknown option '{}'{}", name, suggestion(name, option_names(command)));
  }
  const Names commands = command_names(command);
  if (!commands.empty()) {
    return fmt::format("unknown command '{}'{}", argument, suggestion(argument, commands));
  }
  // The dashes may be missing.
  Names words;
  for (const std::string& name : option_names(command)) words.push_back(name.substr(2));
  const std::string option = yaml::nearest_word(argument.substr(0, argument.find('=')), words);
  return fmt::format("unexpected argument '{}'{}", argument,
                     option.empty() ? "" : fmt::format("; did you mean '--{}'?", option));
}

}  // namespace

std::string usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& command = recognized(app);
  const auto extra = app.remaining(/*recurse=*/true);
  const bool unexpected = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
  const bool missing = dynamic_cast<const CLI::RequiredError*>(&error) != nullptr;
  std::string text = error.what();
  // A missing argument is often a mistyped one.
  if ((unexpected || missing) && !extra.empty()) {
    text = unexpected_text(extra.front(), command);
  } else if (const Names commands = command_names(command); missing && !commands.empty()) {
    text = fmt::format("a command is missing: {}", fmt::join(commands, ", "));
  }
  const std::string name =
      &command == &app ? app.get_name() : app.get_name() + ' ' + command.get_name();
  return fmt::format("{}\nRun '{} --help' for all options.\n", text, name);
}

}  // namespace aprsim::server
