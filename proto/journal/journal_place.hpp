#pragma once

#include <string>
#include <vector>

#include "world/base/result.hpp"

namespace aprsim::journal {

/// The files of one run in their order. `place`: a file, with those in which it goes on (FILE.2,
/// ...), or a directory with the files of one run. Errors: kNotFound, kUnavailable,
/// kInvalidArgument (no journal, of several runs, or a part of one twice).
[[nodiscard]] Result<std::vector<std::string>> files_of_run(const std::string& place);

}  // namespace aprsim::journal
