#pragma once

#include <string>
#include <vector>

namespace aprsim::client {

/// An option, a flag or a positional argument.
struct OptionInfo {
  std::vector<std::string> names;  ///< with their dashes; empty for a positional argument
  /// Placeholder of its value, or its words separated by |; empty for a flag.
  std::string value;
  bool positional = false;
  bool required = false;
  std::string help;
};

/// A command with its options and subcommands.
struct CommandInfo {
  std::string name;
  std::string path;  ///< from the program's name on
  std::string help;
  std::vector<OptionInfo> options;
  std::vector<CommandInfo> commands;
};

/// The whole command line of the parser. Options of the program itself may follow every command.
[[nodiscard]] CommandInfo command_tree();

/// The allowed words of an option's value; empty when it is not a choice of words.
[[nodiscard]] std::vector<std::string> choices(const OptionInfo& option);

}  // namespace aprsim::client
