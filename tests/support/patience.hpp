#pragma once

#include "tests/support/sanitizers.hpp"

namespace aprsim::test {

/// Whether sanitizers take time and memory of their own.
#ifdef APRSIM_SANITIZED
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// Factor on deadlines of the wall clock.
inline constexpr int kPatience = kSanitized ? 10 : 1;

}  // namespace aprsim::test
