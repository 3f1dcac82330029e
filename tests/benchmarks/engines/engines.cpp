// The two ideas of IMECE2019-11345, which claims them for any engine and settings: the gripper's
// law (Fig. 3) and contact simplification (Table 1) on our engine and on ODE, with one gripper and
// one simplification behind the interface of world/physics/engine.

#include "tests/benchmarks/engines/grips.hpp"
#include "tests/benchmarks/engines/trays.hpp"
#include "tests/benchmarks/support/experiment.hpp"

namespace aprsim::bench {
namespace {

int run(int argc, char** argv) {
  Experiment experiment("engines", argc, argv);
  compare_grips(experiment);
  compare_trays(experiment);
  experiment.note(
      "Contact points are the same on both engines, from our collision detection. ODE solves them "
      "with its contact joints: friction pyramids with an edge along the slip, ERP 0.2, CFM 1e-6. "
      "\"quick N\" is dWorldQuickStep with N iterations, \"direct\" dWorldStep.");
  experiment.note(
      "Fig. 3: Fc 60 N, flat pads, medium gear, seven directions, accelerations of 2, 10 and 30 "
      "m/s2 for 0.1 s; the worst of them. A contradiction is a setting in which eq. 1-2 (coupled) "
      "is not better in delta_t than a baseline, or drops more.");
  experiment.note(
      "Table 1: 2 s, the belt starts after 0.5 s. A contradiction is a setting of ODE in which "
      "virtual joints do not make delta_t after settling smaller. Our engine holds contacts at "
      "rest by itself, so that there is nothing to win.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
