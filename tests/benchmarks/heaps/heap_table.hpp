#pragma once

#include <string>

#include "tests/benchmarks/heaps/heap_run.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/table.hpp"

namespace aprsim::bench {

/// The figures of heaps, a row each.
class HeapTable {
 public:
  /// Adds a heap, and records its figures under `name`.
  void add(const std::string& name, const HeapPlan& plan, const std::string& phase,
           const HeapRun& run, Experiment& experiment);
  [[nodiscard]] const Table& table() const { return table_; }

 private:
  Table table_{{"parts", "bodies", "phase", "contacts", "median [us]", "mean [us]", "p99 [us]",
                "longest [us]", "Newton steps", "unsolved", "worst residual [m/s]", "deepest [mm]",
                "lost"}};
};

}  // namespace aprsim::bench
