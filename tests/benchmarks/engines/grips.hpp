#pragma once

#include "tests/benchmarks/support/experiment.hpp"

namespace aprsim::bench {

/// Fig. 3 on every engine, over step sizes and pad friction.
void compare_grips(Experiment& experiment);

}  // namespace aprsim::bench
