#pragma once

#include <string>
#include <vector>

#include "clients/wires/outcome.hpp"

namespace aprsim::client {

/// Replaces this process with a program of the Python package `aprsim`: `python3 -m` and `words`.
/// Returns only when python3 cannot be started.
[[nodiscard]] Outcome<void> become_python(const std::vector<std::string>& words);

}  // namespace aprsim::client
