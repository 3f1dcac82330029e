#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "crcl/commands.hpp"
#include "crcl/guard.hpp"

/// A command with the fields that all commands have, and the two documents that carry commands.
namespace aprsim::crcl {

struct Command {
  std::optional<std::string> name;
  std::int64_t id = 0;  ///< CommandID; 0 when the document has none
  std::vector<Guard> guards;
  CommandBody body;
  bool operator==(const Command&) const = default;
};

/// The root CRCLCommandInstance.
struct CommandInstance {
  std::optional<std::string> name;
  Command command;
  std::optional<std::string> program_file;
  std::optional<int> program_index, program_length;
  bool operator==(const CommandInstance&) const = default;
};

/// The root CRCLProgram: InitCanon first, EndCanon last.
struct Program {
  std::optional<std::string> name;
  std::vector<Command> commands;
  bool operator==(const Program&) const = default;
};

}  // namespace aprsim::crcl
