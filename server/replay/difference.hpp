#pragma once

#include <string>

#include "world/runtime/record/recorder.hpp"

namespace aprsim::server::journal {

/// Where a run that was repeated is not as the journal has it.
struct Difference {
  world::RunTime time;
  std::string what;  ///< which body, joint, belt or wire differs by how much, in words
};

}  // namespace aprsim::server::journal
