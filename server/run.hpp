#pragma once

namespace aprsim::server {

/// The whole program: reads the arguments, serves a cell until a signal ends it, or answers and
/// leaves. Returns the exit code; says on standard error in one line what went wrong.
int run(int argc, char** argv);

}  // namespace aprsim::server
