#pragma once

#include <string>

namespace aprsim::client {

/// A script that bash sources to complete the command line.
[[nodiscard]] std::string bash_completion();
/// The function _aprsim for zsh's fpath; may be sourced too.
[[nodiscard]] std::string zsh_completion();

}  // namespace aprsim::client
