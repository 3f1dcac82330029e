#include "tests/benchmarks/heaps/heap_table.hpp"

#include "tests/benchmarks/support/statistics.hpp"

namespace aprsim::bench {

void HeapTable::add(const std::string& name, const HeapPlan& plan, const std::string& phase,
                    const HeapRun& run, Experiment& experiment) {
  const double half = median(run.step_us), most = percentile(run.step_us, 0.99),
               longest = percentile(run.step_us, 1);
  table_.row({name_of(plan.parts), double(plan.bodies), phase, run.contacts, half,
              mean(run.step_us), most, longest, run.newton_steps, run.unsolved,
              run.worst_residual_m_s, 1e3 * run.deepest_m, double(run.lost)});
  experiment.record(name + ".median_us", half, "us");
  experiment.record(name + ".mean_us", mean(run.step_us), "us");
  experiment.record(name + ".p99_us", most, "us");
  experiment.record(name + ".longest_us", longest, "us");
  experiment.record(name + ".newton_steps", run.newton_steps, "count");
  experiment.record(name + ".unsolved", run.unsolved, "count");
  experiment.record(name + ".deepest_m", run.deepest_m, "m");
  experiment.record(name + ".lost", run.lost, "count");
}

}  // namespace aprsim::bench
