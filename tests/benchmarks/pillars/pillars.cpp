// Pillars of equal discs and slabs upon slopes: when they topple. Discs dropped on each other along
// their axis: whether they stay apart.

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/benchmarks/pillars/coaxial_drop.hpp"
#include "tests/benchmarks/pillars/pillar.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/in_parallel.hpp"
#include "tests/benchmarks/support/modes.hpp"
#include "tests/benchmarks/support/statistics.hpp"

namespace aprsim::bench {
namespace {

constexpr int kFewest = 2, kMost = 8;  // bodies of a pillar
constexpr double kRange = 0.1;         // of the slopes about the closed form

/// Slope at which it topples, over the closed form.
double onset(const Pillar& pillar, int halvings) {
  double stands = 1 - kRange, falls = 1 + kRange;
  const double closed = pillar.toppling_rad();
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (stands + falls);
    (topples(pillar, middle * closed) ? falls : stands) = middle;
  }
  return 0.5 * (stands + falls);
}

void topplings(Experiment& experiment) {
  const int each = experiment.quick() ? 1 : 4, halvings = experiment.quick() ? 4 : 11;
  std::vector<Pillar> pillars;
  std::mt19937_64 engine(48);
  for (int count = kFewest; count <= kMost; count += experiment.quick() ? 3 : 1) {
    for (const bool slabs : {false, true}) {
      for (int i = 0; i < each; ++i) {
        pillars.push_back(random_pillar(engine, slabs, count));
        pillars.back().mode = kModes[static_cast<std::size_t>(i) % kModes.size()].value;
      }
    }
  }
  const auto onsets =
      in_parallel(pillars.size(), [&](std::size_t i) { return onset(pillars[i], halvings); });
  Table table({"body", "count", "mode", "radius or half width [mm]", "thickness [mm]",
               "closed form [rad]", "topples at, over closed form"});
  double discs = 0, slabs = 0;
  for (std::size_t i = 0; i < pillars.size(); ++i) {
    const Pillar& pillar = pillars[i];
    const char* mode = kModes[i % static_cast<std::size_t>(each) % kModes.size()].name;
    table.row({pillar.slabs ? "slab" : "disc", double(pillar.count), mode, 1e3 * pillar.radius_m,
               1e3 * pillar.thickness_m, pillar.toppling_rad(), onsets[i]});
    double& worst = pillar.slabs ? slabs : discs;
    worst = std::max(worst, std::abs(onsets[i] - 1));
  }
  experiment.table("pillars", "Pillars upon slopes", table);
  experiment.record("pillars.disc_toppling_error", discs, "relative");
  experiment.record("pillars.slab_toppling_error", slabs, "relative");
}

void drops(Experiment& experiment) {
  const std::size_t count = experiment.quick() ? 100 : 10'000;
  const auto all = in_parallel(count, [](std::size_t seed) { return coaxial_drop(seed); });
  Table table(
      {"seed", "off the axis [m]", "tilt [rad]", "fall [m]", "equal", "sunk [m]", "deepest [m]"});
  Table shares({"discs", "drops", "passed", "sunk, p99 [m]", "sunk, most [m]", "deepest [m]"});
  int passed = 0;
  double deepest = 0;
  for (const bool equal : {true, false}) {
    std::vector<double> sunk;
    int through = 0;
    double deep = 0;
    for (std::size_t seed = 0; seed < count; ++seed) {
      const CoaxialDrop& one = all[seed];
      if (one.equal != equal) continue;
      sunk.push_back(one.sunk_m);
      through += one.passed() ? 1 : 0;
      deep = std::max(deep, one.deepest_m);
      if (!one.passed() && seed >= 100) continue;  // all failures, and some others
      table.row({double(seed), one.off_axis_m, one.tilt_rad, one.height_m, equal ? "yes" : "no",
                 one.sunk_m, one.deepest_m});
    }
    shares.row({equal ? "equal" : "unequal", double(sunk.size()), double(through),
                percentile(sunk, 0.99), percentile(sunk, 1), deep});
    passed += through;
    deepest = std::max(deepest, deep);
  }
  experiment.table("drops", "", table);
  experiment.table("drops_worst", "Discs dropped on each other along their axis", shares);
  experiment.record("pillars.drops", double(count), "count");
  experiment.record("pillars.drops_passed", passed, "count");
  experiment.record("pillars.drops_deepest_m", deepest, "m");
}

int run(int argc, char** argv) {
  Experiment experiment("pillars", argc, argv);
  topplings(experiment);
  drops(experiment);
  experiment.note(
      "Pillars of 2 to 8 equal bodies, 10 to 30 mm thick, upon slopes with friction 2; discs, and "
      "slabs whose edge is across the slope, such that they topple at 0.1 to 0.5 rad. Toppled: a "
      "body's axis is 0.03 rad off the normal within 3 s. The slope of the onset by halving, to "
      "1e-4 of its closed form, atan(2 R / (n h)).");
  experiment.note(
      "Drops: discs of 8 to 50 mm, half of them equal, some upon hubs. They fall from 0 to 5 mm, "
      "0 or 1e-12 to 1e-3 m off the axis, tilted by 0 or 1e-9 to 1e-3 rad. Restitution up to 0.5, "
      "all modes. Passed: more than 1 mm lower than upon the other disc after 0.5 s.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
