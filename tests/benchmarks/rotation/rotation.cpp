// Rotation that conserves: free bodies over ten minutes, and heavy tops against the integrated
// equations.

#include <algorithm>
#include <vector>

#include "tests/benchmarks/rotation/free_spin.hpp"
#include "tests/benchmarks/rotation/heavy_top.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/in_parallel.hpp"
#include "tests/benchmarks/support/modes.hpp"

namespace aprsim::bench {
namespace {

constexpr double kFastest = 60;  // [rad/s]

void free_spins(Experiment& experiment) {
  std::mt19937_64 engine(46);
  std::vector<FreeSpin> spins(experiment.quick() ? 4 : 40);
  for (std::size_t i = 0; i < spins.size(); ++i) {
    spins[i] = random_free_spin(engine, kFastest);
    spins[i].scene.physics.simplification = kModes[i % kModes.size()].value;
  }
  const double seconds = experiment.quick() ? 5 : 600;
  const auto all =
      in_parallel(spins.size(), [&](std::size_t i) { return errors_of(spins[i], seconds); });
  Table table({"mode", "body", "rate [rad/s]", "energy error", "angular momentum error"});
  SpinErrors worst;
  for (std::size_t i = 0; i < spins.size(); ++i) {
    table.row({kModes[i % kModes.size()].name, spins[i].scene.trays.empty() ? "gear" : "slab",
               spins[i].omega_W.norm(), all[i].energy, all[i].angular_momentum});
    worst.energy = std::max(worst.energy, all[i].energy);
    worst.angular_momentum = std::max(worst.angular_momentum, all[i].angular_momentum);
  }
  experiment.table("free", "", table);
  experiment.record("rotation.energy_error", worst.energy, "relative");
  experiment.record("rotation.angular_momentum_error", worst.angular_momentum, "relative");
}

/// One way to start and to stand.
struct Kind {
  const char* name;
  bool steady;
  double friction;
};
constexpr std::array kKinds = {Kind{"regular precession, point sticks", true, 1},
                               Kind{"regular precession, no friction", true, 0},
                               Kind{"from rest, point sticks", false, 1},
                               Kind{"from rest, no friction", false, 0}};

void tops(Experiment& experiment) {
  const std::size_t count = experiment.quick() ? 1 : 25;
  const double seconds = experiment.quick() ? 2 : 10;
  std::vector<Top> cases;
  for (const Kind& kind : kKinds) {
    std::mt19937_64 engine(47);
    for (std::size_t i = 0; i < count; ++i) {
      Top top = random_top(engine);
      top.steady = kind.steady;
      top.friction = kind.friction;
      top.mode = kModes[i % kModes.size()].value;
      cases.push_back(top);
    }
  }
  const auto all =
      in_parallel(cases.size(), [&](std::size_t i) { return spin(cases[i], seconds); });
  Table table({"start", "tilt [rad]", "spin [rad/s]", "precession [rad]", "tilt error",
               "precession error", "way of the point [m]"});
  Table worst({"start", "tops", "tilt error, greatest", "precession error, greatest",
               "way of a sticking point [m]"});
  double tilt = 0, precession = 0;
  for (std::size_t k = 0; k < kKinds.size(); ++k) {
    TopErrors most;
    for (std::size_t i = k * count; i < (k + 1) * count; ++i) {
      const TopErrors& one = all[i];
      table.row({kKinds[k].name, cases[i].tilt_rad, cases[i].spin_rad_s, one.precession_rad,
                 one.tilt, one.precession, one.point_m});
      most.tilt = std::max(most.tilt, one.tilt);
      most.precession = std::max(most.precession, one.precession);
      most.point_m = std::max(most.point_m, cases[i].friction > 0 ? one.point_m : 0);
    }
    worst.row({kKinds[k].name, double(count), most.tilt, most.precession, most.point_m});
    tilt = std::max(tilt, most.tilt);
    precession = std::max(precession, most.precession);
  }
  experiment.table("tops", "", table);
  experiment.table("tops_worst", "Heavy tops against the integrated equations", worst);
  experiment.record("rotation.top.tilt_error", tilt, "relative");
  experiment.record("rotation.top.precession_error", precession, "relative");
}

int run(int argc, char** argv) {
  Experiment experiment("rotation", argc, argv);
  free_spins(experiment);
  tops(experiment);
  experiment.note(
      "Free: slabs and gears of random size turn about any axis at 1 to 60 rad/s for ten minutes "
      "without gravity, in all modes in turns; greatest errors at any second.");
  experiment.note(
      "Tops: a disc of 30 to 50 mm on the point of a cone, 15 to 30 mm below it, tilted by 0.1 rad "
      "or more. It spins at 100 to 200 rad/s on a plate for 10 s, and its disc stays clear. It "
      "starts in regular precession, or "
      "with spin alone, so that it nods. Friction 1 keeps the point where it stands; without "
      "friction the centre of mass moves along the vertical alone. Equations of the symmetric top, "
      "integrated in steps of 50 us. Tilt: difference of the least and of the greatest tilt in the "
      "last second, over the latter; precession: difference after 10 s over the way.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
