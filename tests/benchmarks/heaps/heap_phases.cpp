#include "tests/benchmarks/heaps/heap_phases.hpp"

#include <vector>

#include "tests/benchmarks/heaps/heap_run.hpp"
#include "tests/benchmarks/heaps/heap_table.hpp"
#include "tests/benchmarks/support/experiment.hpp"

namespace aprsim::bench {
namespace {

constexpr double kLanded = 0.3, kHeaped = 0.6, kSettled = 1.0, kEnd = 1.25;  // [s]

}  // namespace

int run_heap_phases(const std::string& name, bool walls, const std::string& place, int argc,
                    char** argv) {
  Experiment experiment(name, argc, argv);
  const std::vector<int> sizes = experiment.quick() ? std::vector{20} : std::vector{50, 100, 200};
  HeapTable table;
  for (const HeapParts parts : {HeapParts::kGears, HeapParts::kTrays, HeapParts::kMixed}) {
    for (const int bodies : sizes) {
      const HeapPlan plan{.parts = parts, .bodies = bodies, .walls = walls};
      const std::string row = name + "." + name_of(parts) + "." + std::to_string(bodies);
      table.add(row + ".impact", plan, "impact", run_heap(plan, kLanded, kHeaped), experiment);
      if (experiment.quick()) continue;
      table.add(row + ".settling", plan, "settling", run_heap(plan, kSettled, kEnd), experiment);
    }
  }
  experiment.table("heaps", "Heaps " + place, table.table());
  experiment.note(
      "Parts at random attitudes fall in layers " + place +
      ". All stay awake. \"Impact\" is from 0.3 to 0.6 s, \"settling\" from 1.0 to "
      "1.25 s. Times are of the thread's processor. \"Unsolved\" are solves that missed "
      "their tolerance.");
  return experiment.finish();
}

}  // namespace aprsim::bench
