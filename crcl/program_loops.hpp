#pragma once

#include <cstddef>
#include <vector>

#include "crcl/documents.hpp"
#include "crcl/error.hpp"

namespace aprsim::crcl {

inline constexpr std::size_t kMaxExpandedCommands = 1'000'000;

/// The commands of a program in the order of execution, as indices into `program.commands`. The
/// commands of a loop block are repeated MaxCount times. Loops may be nested.
/// Errors: kBadValue for a start or end without its counterpart, and for a program that grows
/// beyond `max_commands`.
[[nodiscard]] Result<std::vector<std::size_t>> expand_loops(
    const Program& program, std::size_t max_commands = kMaxExpandedCommands);

}  // namespace aprsim::crcl
