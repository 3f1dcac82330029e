#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "clients/aprsim/cli/screen.hpp"

namespace aprsim::client {

/// The whole program: parses, runs one command, prints. Returns one of kExitCodes. The screen is
/// that of `out` and `err`; by default they are none.
int run(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err,
        const Screen& screen = {});

}  // namespace aprsim::client
