// How the time of a step grows with the number of bodies in one heap.

#include <string>
#include <vector>

#include "tests/benchmarks/heaps/heap_run.hpp"
#include "tests/benchmarks/heaps/heap_table.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/statistics.hpp"

namespace aprsim::bench {
namespace {

constexpr double kLanded = 0.4, kEnd = 0.5;  // [s]

int run(int argc, char** argv) {
  Experiment experiment("growth", argc, argv);
  const std::vector<int> sizes =
      experiment.quick() ? std::vector{10, 20, 30} : std::vector{50, 100, 200, 500, 1000};
  HeapTable table;
  Plot plot{.title = "Mean time of a step of a heap in a bin",
            .x = {.label = "awake bodies", .log = true},
            .y = {.label = "[us]", .log = true}};
  for (const HeapParts parts : {HeapParts::kGears, HeapParts::kTrays, HeapParts::kMixed}) {
    Series series{name_of(parts), {}};
    std::vector<double> contacts, times_us, bodies;
    for (const int size : sizes) {
      const HeapPlan plan{.parts = parts, .bodies = size, .walls = true};
      const HeapRun run = run_heap(plan, kLanded, kEnd);
      table.add("growth." + name_of(parts) + "." + std::to_string(size), plan, "impact", run,
                experiment);
      bodies.push_back(size);
      contacts.push_back(run.contacts);
      times_us.push_back(mean(run.step_us));
      series.points.emplace_back(size, times_us.back());
    }
    experiment.record("growth." + name_of(parts) + ".exponent", growth_exponent(bodies, times_us),
                      "exponent");
    experiment.record("growth." + name_of(parts) + ".exponent_of_contacts",
                      growth_exponent(contacts, times_us), "exponent");
    plot.series.push_back(series);
  }
  experiment.table("heaps", "Heaps of 50 to 1000 bodies in a bin", table.table());
  experiment.plot("growth", plot);
  experiment.note(
      "Heaps as in the experiment `bin`, timed from 0.4 to 0.5 s, when most bodies have landed. "
      "The "
      "exponents are of the mean time over bodies, and over contacts.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
