#pragma once

#include <string>
#include <vector>

namespace aprsim::client {

/// An option, a flag or an argument without a name.
struct OptionInfo {
  std::vector<std::string> names;  ///< with their dashes; none for what has no name
  /// Of what it takes: a placeholder, or the words it can be with | between; empty for a flag.
  std::string value;
  bool positional = false;
  bool required = false;
  std::string help;
};

/// A command with its options and the commands below it.
struct CommandInfo {
  std::string name;
  std::string path;  ///< from the program's name on
  std::string help;
  std::vector<OptionInfo> options;
  std::vector<CommandInfo> commands;
};

/// The whole command line as the parser knows it. Options of the program itself may follow every
/// command.
[[nodiscard]] CommandInfo command_tree();

/// The words that an option's value can be; none when it is anything else.
[[nodiscard]] std::vector<std::string> choices(const OptionInfo& option);

}  // namespace aprsim::client
