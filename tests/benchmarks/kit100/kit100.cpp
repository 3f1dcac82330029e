// A kit of a hundred parts that a gripper empties, one part after another, into another kit.

#include "tests/benchmarks/kit100/kit_picking.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/modes.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/benchmarks/support/tails.hpp"

namespace aprsim::bench {
namespace {

int run(int argc, char** argv) {
  Experiment experiment("kit100", argc, argv);
  const KitPicking kit = pick_kit(kDefaultMode.value, experiment.quick() ? 2 : 100);
  Table table({"mode", "picked", "placed", "step, mean [us]", "p99 [us]", "p99.9 [us]",
               "longest [us]", "deepest [um]", "unsolved steps"});
  table.row({kDefaultMode.name, double(kit.picked), double(kit.placed), mean(kit.step_us),
             percentile(kit.step_us, 0.99), percentile(kit.step_us, 0.999),
             percentile(kit.step_us, 1), 1e6 * kit.deepest_m, double(kit.unsolved)});
  experiment.table("kit", "A kit of a hundred parts, picked from", table);
  experiment.plot("tails", {.title = "Steps that take longer",
                            .x = {.label = "share of steps", .log = true},
                            .y = {.label = "us", .log = true},
                            .series = {tails(kDefaultMode.name, kit.step_us)}});
  experiment.record("kit100.step_mean_us", mean(kit.step_us), "us");
  experiment.record("kit100.step_p999_us", percentile(kit.step_us, 0.999), "us");
  experiment.record("kit100.step_max_us", percentile(kit.step_us, 1), "us");
  experiment.record("kit100.picked", kit.picked, "count");
  experiment.record("kit100.placed", kit.placed, "count");
  experiment.record("kit100.left_moved_m", kit.moved_m, "m");
  experiment.record("kit100.unsolved_steps", double(kit.unsolved), "count");
  experiment.note(
      "Ten by ten pockets; both kits, the hand and all hundred parts are in the scene from the "
      "first step to the last. Every step is timed once, but for the first second, in which all "
      "comes to rest.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
