// Ten simulated minutes of the cell at work, and the same commands at the same steps once more,
// with the state saved and loaded into another world in the middle: every state hash must be the
// same, in every mode of contact simplification.

#include <memory>

#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/modes.hpp"
#include "tests/support/cell_script.hpp"
#include "tests/support/replay.hpp"

namespace aprsim::bench {
namespace {

// The default mode is one experiment, the others, which take many times as long, another.
#ifdef APRSIM_SLOW_MODES
constexpr const char* kName = "determinism_slow";
constexpr bool kSlow = true;
#else
constexpr const char* kName = "determinism";
constexpr bool kSlow = false;
#endif

int run(int argc, char** argv) {
  Experiment experiment(kName, argc, argv);
  const double seconds = experiment.quick() ? 2.5 : 600;
  Table table({"mode", "simulated [s]", "commands", "trips", "hashes", "mismatches"});
  Plot plot{.title = "Trips of both robots in ten simulated minutes",
            .x = {.label = "simulated time [s]"},
            .y = {.label = "trips"}};
  int mismatches = 0;
  for (const auto& mode : kModes) {
    if (kSlow == (mode.value == kDefaultMode.value)) continue;
    auto scene = std::make_shared<scene::Scene>(*test::load_scene("aprs"));
    scene->physics.simplification = mode.value;
    const auto first = test::record_demo(scene, seconds);
    const auto again = test::replay_demo(scene, first);
    const int differing = test::count_mismatches(first, again);
    mismatches += differing;
    table.row({mode.name, seconds, static_cast<double>(first.commands.size()),
               static_cast<double>(first.trips.back()), static_cast<double>(first.hashes.size()),
               static_cast<double>(differing)});
    experiment.record(std::string("determinism.") + mode.name + ".mismatches", differing, "count");
    experiment.record(std::string("determinism.") + mode.name + ".trips", first.trips.back(),
                      "count");
    Series trips{mode.name, {}};
    const std::size_t stride = std::max<std::size_t>(1, first.trips.size() / 60);
    for (std::size_t i = 0; i < first.trips.size(); i += stride) {
      trips.points.emplace_back(test::kHashPeriodS * static_cast<double>(i + 1), first.trips[i]);
    }
    plot.series.push_back(trips);
  }
  experiment.record(std::string(kName) + ".mismatches", mismatches, "count");
  experiment.table("modes", "Hashes of the cell's state, compared between two runs", table);
  experiment.plot("trips", plot);
  experiment.note(
      "Both robots carry gears to and fro, the belt carries trays in between; a hash every 10 ms "
      "of simulated time. In the middle of the second run its state is saved and loaded into a new "
      "world, which goes on.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
