#pragma once

#include <ostream>
#include <string>
#include <vector>

namespace aprsim::server {

/// `aprsimd token ...`: creates, lists and removes entries of the access file, without a daemon.
/// `arguments`: those after "token". Returns the exit code: 0, 1 = refused, 2 = wrong arguments.
int token_command(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err);

}  // namespace aprsim::server
