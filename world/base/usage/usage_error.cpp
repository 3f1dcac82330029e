#include "world/base/usage/usage_error.hpp"

#include <algorithm>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "world/base/usage/suggestion.hpp"

namespace aprsim::usage {
namespace {

/// The parsers from the program down to the last recognised command.
std::vector<const CLI::App*> understood(const CLI::App& app) {
  std::vector<const CLI::App*> path{&app};
  for (auto chosen = app.get_subcommands(); !chosen.empty();
       chosen = path.back()->get_subcommands()) {
    path.push_back(chosen.front());
  }
  return path;
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const auto* sub : app.get_subcommands(nullptr)) names.push_back(sub->get_name());
  return names;
}

std::vector<std::string> option_names(const std::vector<const CLI::App*>& path) {
  std::vector<std::string> names;
  for (const auto* app : path) {
    for (const auto* option : app->get_options()) {
      for (const auto& name : option->get_lnames()) names.push_back("--" + name);
    }
  }
  return names;
}

/// The first unexpected argument.
std::string unexpected_text(const std::string& argument, const std::vector<const CLI::App*>& path) {
  const std::string name = argument.substr(0, argument.find('='));
  const auto options = option_names(path);
  if (argument.starts_with('-')) {
    return fmt::format("unknown option '{}'{}", name, suggestion(name, options));
  }
  if (const auto commands = command_names(*path.back()); !commands.empty()) {
    return fmt::format("unknown command '{}'{}", argument, suggestion(argument, commands));
  }
  // The dashes may be missing; other arguments are no options.
  const auto option = nearest("--" + name, options);
  const bool meant = option && edit_distance("--" + name, *option) <= 1;
  return fmt::format("unexpected argument '{}'{}", argument,
                     meant ? "; did you mean '" + *option + "'?" : "");
}

std::string path_text(const std::vector<const CLI::App*>& path) {
  std::string text;
  for (const auto* app : path) text += (text.empty() ? "" : " ") + app->get_name();
  return text;
}

}  // namespace

std::string usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const auto path = understood(app);
  const auto extra = app.remaining(/*recurse=*/true);
  std::string text = error.what();
  // A missing word was often mistyped.
  const bool unexpected = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
  const bool missing = dynamic_cast<const CLI::RequiredError*>(&error) != nullptr;
  if ((unexpected || missing) && !extra.empty()) {
    text = unexpected_text(extra.front(), path);
  } else if (const auto commands = command_names(*path.back()); missing && !commands.empty()) {
    text = fmt::format("a command is missing: {}", fmt::join(commands, ", "));
  }
  return fmt::format("{}\nRun '{} --help' for all options.\n", text, path_text(path));
}

}  // namespace aprsim::usage
