// Parts fall on a table and make a pile: the cost and the exactness of a step.

#include <string>
#include <vector>

#include "tests/benchmarks/heaps/heap_run.hpp"
#include "tests/benchmarks/heaps/heap_table.hpp"
#include "tests/benchmarks/support/experiment.hpp"

namespace aprsim::bench {
namespace {

constexpr double kLanded = 0.3, kHeaped = 0.6, kSettled = 1.0, kEnd = 1.25;  // [s]

int run(int argc, char** argv) {
  Experiment experiment("pile", argc, argv);
  const std::vector<int> sizes = experiment.quick() ? std::vector{20} : std::vector{50, 100, 200};
  HeapTable table;
  for (const HeapParts parts : {HeapParts::kGears, HeapParts::kTrays, HeapParts::kMixed}) {
    for (const int bodies : sizes) {
      const HeapPlan plan{.parts = parts, .bodies = bodies, .walls = false};
      const std::string name = "pile." + name_of(parts) + "." + std::to_string(bodies);
      table.add(name + ".impact", plan, "impact", run_heap(plan, kLanded, kHeaped), experiment);
      if (experiment.quick()) continue;
      table.add(name + ".settling", plan, "settling", run_heap(plan, kSettled, kEnd), experiment);
    }
  }
  experiment.table("heaps", "Piles on a table", table.table());
  experiment.note(
      "Parts at random attitudes fall in layers on a table. All stay awake. \"Impact\" is from "
      "0.3 to 0.6 s, \"settling\" from 1.0 to 1.25 s. Times are of the thread's processor. "
      "\"Unsolved\" are solves that missed their tolerance.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
