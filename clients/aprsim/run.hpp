#pragma once

#include <iosfwd>
#include <string>
#include <vector>

namespace aprsim::client {

/// The whole program: parses, runs one command, prints. Returns the exit code: 0 = done as asked,
/// 1 = the cell refused it or the result is not what it should be, 2 = wrong arguments or file,
/// 3 = no connection, 4 = no answer or no end in time.
int run(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err);

}  // namespace aprsim::client
