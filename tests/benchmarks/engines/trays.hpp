#pragma once

#include "tests/benchmarks/support/experiment.hpp"

namespace aprsim::bench {

/// Table 1 on every engine, over step sizes and friction.
void compare_trays(Experiment& experiment);

}  // namespace aprsim::bench
