#pragma once

#include <vector>

#include "clients/aprsim/outcome.hpp"
#include "crcl/documents.hpp"

namespace aprsim::client {

/// The commands of a program in the order of execution: what stands between the start and the end
/// of a loop block comes MaxCount times, as a client does it (a loop never goes over the wire).
/// Loops may be nested; a start or end without its counterpart is kUsage, and so is a program that
/// grows beyond a million commands.
[[nodiscard]] Outcome<std::vector<crcl::Command>> expand_loops(const crcl::Program& program);

}  // namespace aprsim::client
