#pragma once

/// Defined where AddressSanitizer or ThreadSanitizer watches the program. GCC and clang report this
/// in different ways.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define APRSIM_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define APRSIM_SANITIZED
#endif
#endif
