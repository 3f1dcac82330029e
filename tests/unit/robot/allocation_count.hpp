#pragma once

#include <cstdint>

namespace aprsim::robot {

/// Calls of operator new in this program so far.
std::int64_t allocation_count();

}  // namespace aprsim::robot
