#pragma once

#include <string>

#include "world/runtime/record/recorder.hpp"

namespace aprsim::server::journal {

/// The first place where a replay differs from the journal.
struct Difference {
  world::RunTime time;
  std::string text;  ///< the body, joint, belt or wire, and by how much it differs
};

}  // namespace aprsim::server::journal
