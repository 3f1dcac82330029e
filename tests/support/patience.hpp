#pragma once

#include "tests/support/sanitizers.hpp"

namespace aprsim::test {

<<<<<<< HEAD
/// Whether sanitizers take time and memory of their own. GCC has macros, clang features.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
inline constexpr bool kSanitized = true;
=======
/// Factor on deadlines of the wall clock: sanitizers take their time.
#ifdef APRSIM_SANITIZED
inline constexpr int kPatience = 10;
>>>>>>> checks
#else
inline constexpr bool kSanitized = false;
#endif
#else
inline constexpr bool kSanitized = false;
#endif

/// Factor on deadlines of the wall clock.
inline constexpr int kPatience = kSanitized ? 10 : 1;

}  // namespace aprsim::test
