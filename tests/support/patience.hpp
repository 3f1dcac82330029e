#pragma once

#include "tests/support/sanitizers.hpp"

namespace aprsim::test {

/// Factor on deadlines of the wall clock: sanitizers take their time.
#ifdef APRSIM_SANITIZED
inline constexpr int kPatience = 10;
#else
inline constexpr int kPatience = 1;
#endif

}  // namespace aprsim::test
