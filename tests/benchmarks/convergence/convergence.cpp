// Orders with which held, rolling, sliding and spinning parts converge as the step shrinks.

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tests/benchmarks/convergence/motions.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/in_parallel.hpp"

namespace aprsim::bench {
namespace {

constexpr std::array kSteps = {2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4};
constexpr std::size_t kFitted = 4;  // steps that an order is fitted to
constexpr double kLeast = 1e-16;    // error that counts as none

/// A kind of motion, and how to draw one.
struct Kind {
  std::string name, unit;
  std::function<std::unique_ptr<Motion>(std::mt19937_64&)> draw;
};

const std::vector<Kind> kKinds = {
    {"held", "m", [](auto& engine) { return std::make_unique<HeldMotion>(engine, false); }},
    {"held_midway", "m", [](auto& engine) { return std::make_unique<HeldMotion>(engine, true); }},
    {"rolling", "m", [](auto& engine) { return std::make_unique<RollingMotion>(engine); }},
    {"sliding", "m", [](auto& engine) { return std::make_unique<SlidingMotion>(engine); }},
    {"spinning", "rad", [](auto& engine) { return std::make_unique<SpinningMotion>(engine); }}};

/// By step: the root of the mean square of the errors against the closed form, and of the
/// differences from half the step.
struct Errors {
  std::vector<double> closed, halved;
  bool has_closed_form = false;
};

Errors errors_of(const Kind& kind, std::size_t cases) {
  std::mt19937_64 engine(49);
  std::vector<std::unique_ptr<Motion>> motions;
  for (std::size_t i = 0; i < cases; ++i) motions.push_back(kind.draw(engine));
  const auto ends = in_parallel(cases * kSteps.size(), [&](std::size_t i) {
    return motions[i / kSteps.size()]->simulated(kSteps[i % kSteps.size()]);
  });
  Errors out;
  out.has_closed_form = motions.front()->closed_form().allFinite();
  for (std::size_t s = 0; s < kFitted; ++s) {
    double closed = 0, halved = 0;
    for (std::size_t i = 0; i < cases; ++i) {
      const Eigen::Vector3d& end = ends[i * kSteps.size() + s];
      closed += (end - motions[i]->closed_form()).squaredNorm();
      halved += (end - ends[i * kSteps.size() + s + 1]).squaredNorm();
    }
    out.closed.push_back(std::max(kLeast, std::sqrt(closed / double(cases))));
    out.halved.push_back(std::max(kLeast, std::sqrt(halved / double(cases))));
  }
  return out;
}

/// Slope of the logarithms, by least squares.
double order_of(const std::vector<double>& errors) {
  double x = 0, y = 0, xx = 0, xy = 0;
  const auto n = double(errors.size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const double a = std::log(kSteps[i]), b = std::log(errors[i]);
    x += a, y += b, xx += a * a, xy += a * b;
  }
  return (n * xy - x * y) / (n * xx - x * x);
}

int run(int argc, char** argv) {
  Experiment experiment("convergence", argc, argv);
  Table table({"motion", "error", "2 ms", "1 ms", "0.5 ms", "0.25 ms", "order"});
  Plot plot{.title = "Error over the step",
            .x = {.label = "step [ms]", .log = true},
            .y = {.label = "error [m, rad]", .log = true, .floor = 1e-14}};
  for (const Kind& kind : kKinds) {
    const Errors errors = errors_of(kind, experiment.quick() ? 1 : 10);
    const auto add = [&](const char* what, const std::vector<double>& e) {
      table.row({kind.name, what + (" [" + kind.unit + "]"), e[0], e[1], e[2], e[3], order_of(e)});
    };
    const std::string name = "convergence." + kind.name;
    if (errors.has_closed_form) {
      add("against the closed form", errors.closed);
      experiment.record(name + ".order", order_of(errors.closed), "");
      experiment.record(name + ".error_1ms", errors.closed[1], kind.unit);
    }
    add("against half the step", errors.halved);
    experiment.record(name + ".self_order", order_of(errors.halved), "");
    Series series{.name = kind.name};
    for (std::size_t s = 0; s < kFitted; ++s) {
      series.points.emplace_back(1e3 * kSteps[s],
                                 errors.has_closed_form ? errors.closed[s] : errors.halved[s]);
    }
    plot.series.push_back(std::move(series));
  }
  experiment.table("orders", "Errors as the step shrinks", table);
  experiment.plot("errors", plot);
  experiment.note(
      "Root of the mean square over ten random cases, mode off. Held: place in the hand of a gear "
      "between flat pads, without gravity, at rest after a random turn as in `turning`, or half "
      "way through it. Rolling: a cylinder down a slope of 0.05 to 0.4 rad for 0.5 s. Sliding: a "
      "tray at 0.3 to 1 m/s, for 0.5 s or until it rests. Spinning: a disc about the vertical, "
      "slowed by friction with even pressure, 2/3 mu N R. Orders: slope of the logarithms.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
