#pragma once

/// Before a function's definition: compiles it, with all that it calls, for wider vector registers
/// as well; the processor at hand selects at load time. The bits are the same on all processors,
/// for no fused multiply-add is used. Not under sanitizers, which start after the selection.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define APRSIM_VECTOR_CLONES [[gnu::target_clones("avx2", "default"), gnu::flatten]]
#else
#define APRSIM_VECTOR_CLONES
#endif
