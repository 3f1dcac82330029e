#pragma once

/// Before a function's definition: it is compiled for wider vector registers as well, and the
/// processor at hand decides. What it calls is compiled with it. The same bits on all: no fused
/// multiply-add among them.
/// Sanitizers have no part in it: they are not there yet when the decision is made.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define APRSIM_VECTOR_CLONES [[gnu::target_clones("avx2", "default"), gnu::flatten]]
#else
#define APRSIM_VECTOR_CLONES
#endif
