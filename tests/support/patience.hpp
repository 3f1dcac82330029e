#pragma once

namespace aprsim::test {

/// Factor on deadlines of the wall clock: sanitizers take their time.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr int kPatience = 10;
#else
inline constexpr int kPatience = 1;
#endif

}  // namespace aprsim::test
