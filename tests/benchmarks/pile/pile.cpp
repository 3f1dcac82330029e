// Parts fall on a table and make a pile: the cost and the exactness of a step.

#include "tests/benchmarks/heaps/heap_phases.hpp"

int main(int argc, char** argv) {
  return aprsim::bench::run_heap_phases("pile", false, "on a table", argc, argv);
}
