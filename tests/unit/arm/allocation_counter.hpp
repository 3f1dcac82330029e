#pragma once

namespace aprsim::robot::test {

/// Heap allocations of this program so far, by operator new and by the C functions.
long allocations();

}  // namespace aprsim::robot::test
