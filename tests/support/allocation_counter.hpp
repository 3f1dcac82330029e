#pragma once

namespace aprsim::test {

/// Heap allocations of the calling thread so far, by whatever function. Linking this file replaces
/// the program's malloc; under a sanitizer its allocator's hook counts instead.
long allocations();

}  // namespace aprsim::test
