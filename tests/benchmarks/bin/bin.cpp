// Parts fall into a bin: the cost and the exactness of a step.

#include "tests/benchmarks/heaps/heap_phases.hpp"

int main(int argc, char** argv) {
  return aprsim::bench::run_heap_phases("bin", true, "into a bin with walls", argc, argv);
}
