#pragma once

#include <string>
#include <vector>

#include "clients/wires/outcome.hpp"

/// Programs that an export runs to their end.
namespace aprsim::trace {

/// Runs a program, whose output goes to a file, and returns its exit code. Failures: kUsage when it
/// cannot be started, kInterrupted.
[[nodiscard]] client::Outcome<int> run_program(const std::vector<std::string>& arguments,
                                               const std::string& log);
/// The bytes of a file; empty when it cannot be read.
[[nodiscard]] std::string content_of(const std::string& file);

}  // namespace aprsim::trace
