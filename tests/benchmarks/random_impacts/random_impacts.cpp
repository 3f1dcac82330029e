// Impacts of random parts in free space: energy, momentum and angular momentum.

#include <algorithm>
#include <numeric>
#include <vector>

#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/in_parallel.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/unit/world/physics/random_impact.hpp"

namespace aprsim::bench {
namespace {

using physics::test::ImpactOutcome;

constexpr std::size_t kShown = 10;  // of the impacts with the greatest energy ratio
constexpr double kGain = 1e-9;

int run(int argc, char** argv) {
  Experiment experiment("random_impacts", argc, argv);
  const std::size_t count = experiment.quick() ? 300 : 1'000'000;
  const auto impacts =
      in_parallel(count, [](std::size_t seed) { return physics::test::random_impact(seed); });
  std::vector<double> gains, momenta, angular;
  int touched = 0, gained = 0;
  for (const ImpactOutcome& impact : impacts) {
    touched += impact.touched ? 1 : 0;
    gained += impact.energy_ratio > 1 + kGain ? 1 : 0;
    gains.push_back(impact.energy_ratio - 1);
    momenta.push_back(impact.momentum_error);
    angular.push_back(impact.angular_momentum_error);
  }
  Table shares({"error", "median", "p99", "p99.99", "greatest"});
  const auto row = [&](const char* name, const std::vector<double>& samples) {
    shares.row({name, percentile(samples, 0.5), percentile(samples, 0.99),
                percentile(samples, 0.9999), percentile(samples, 1)});
  };
  row("energy gained, relative", gains);
  row("momentum, relative", momenta);
  row("angular momentum, relative", angular);
  experiment.table("errors", "Impacts of random parts in free space", shares);
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::partial_sort(order.begin(), order.begin() + kShown, order.end(),
                    [&](std::size_t a, std::size_t b) { return gains[a] > gains[b]; });
  Table worst({"seed", "energy gained, relative", "momentum", "angular momentum"});
  for (std::size_t i = 0; i < kShown; ++i) {
    const std::size_t seed = order[i];
    worst.row({double(seed), gains[seed], momenta[seed], angular[seed]});
  }
  experiment.table("worst", "", worst);
  experiment.record("random_impacts.count", double(count), "count");
  experiment.record("random_impacts.touched", touched, "count");
  experiment.record("random_impacts.energy_gained", percentile(gains, 1), "relative");
  experiment.record("random_impacts.with_energy_gained", gained, "count");
  experiment.record("random_impacts.momentum_error", percentile(momenta, 1), "relative");
  experiment.record("random_impacts.angular_momentum_error", percentile(angular, 1), "relative");
  experiment.note(
      "Gears and trays of random types meet at 0.1 to 10 m/s, turning at up to 30 rad/s, with "
      "restitution and friction from 0 to 1, without gravity. A fifth of them have parallel axes, "
      "half of these in one plane. Kinetic energy in any step over that before; momentum and "
      "angular momentum about the common centre of mass, relative to the sum of the bodies' own.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
