// The whole default cell: how long one step takes, at rest and with both robots picking and
// placing.

#include <algorithm>
#include <functional>
#include <memory>

#include "tests/benchmarks/support/clock.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/modes.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/support/cell_script.hpp"
#include "tests/support/kitting_demo.hpp"

namespace aprsim::bench {
namespace {

/// Times of the steps of one run [us].
struct StepTimes {
  std::vector<double> step, publish;
  std::vector<double> gripping;  ///< of those in which both robots had a gear between their fingers
  int trips = 0;

  [[nodiscard]] double real_time_factor(double step_s) const {
    return step_s * 1e6 / (mean(step) + mean(publish));
  }
};

std::shared_ptr<const scene::Scene> default_cell(const Mode& mode) {
  auto scene = std::make_shared<scene::Scene>(*test::load_scene("aprs"));
  scene->physics.simplification = mode.value;
  return scene;
}

void time_step(world::World& world, api::Snapshot& snapshot, StepTimes& times) {
  const double start = thread_cpu_s();
  world.step();
  const double stepped = thread_cpu_s();
  world.write(snapshot);
  const double end = thread_cpu_s();
  times.step.push_back(1e6 * (stepped - start));
  times.publish.push_back(1e6 * (end - stepped));
}

StepTimes at_rest(const Mode& mode, int steps) {
  world::World world(default_cell(mode), 1);
  api::Snapshot snapshot;
  for (int step = 0; step < 1000; ++step) world.step();
  StepTimes times;
  for (int step = 0; step < steps; ++step) time_step(world, snapshot, times);
  return times;
}

StepTimes at_work(const Mode& mode, int steps, bool belt) {
  world::World world(default_cell(mode), 1);
  test::KittingDemo demo(world, belt);
  api::Snapshot snapshot;
  for (int step = 0; step < 500; ++step) world.step();
  StepTimes times;
  for (int step = 0; step < steps; ++step) {
    demo.command();
    time_step(world, snapshot, times);
    demo.observe();
    if (demo.both_gripping()) times.gripping.push_back(times.step.back());
  }
  times.trips = demo.trips();
  return times;
}

/// Ten simulated minutes of both robots at work: steps over a millisecond.
void ten_minutes(Experiment& experiment) {
  const int steps = experiment.quick() ? 2000 : 600'000;
  const StepTimes work = at_work(kDefaultMode, steps, true);
  const auto over = std::count_if(work.step.begin(), work.step.end(),
                                  [](double step_us) { return step_us > 1000; });
  experiment.record("cell.ten_minutes.steps_over_1ms", double(over), "count");
  experiment.record("cell.ten_minutes.step_max_us", percentile(work.step, 1), "us");
  experiment.record("cell.ten_minutes.trips", work.trips, "count");
}

Series distribution(const std::string& name, const std::vector<double>& samples) {
  Series series{name, {}};
  for (const double tail : {0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, 0.0002}) {
    series.points.emplace_back(tail, percentile(samples, 1 - tail));
  }
  return series;
}

void row(Table& table, const std::string& mode, const std::string& what,
         const std::vector<double>& samples, double rtf) {
  table.row({mode, what, mean(samples), percentile(samples, 0.5), percentile(samples, 0.99),
             percentile(samples, 0.999), percentile(samples, 1), rtf});
}

int run(int argc, char** argv) {
  Experiment experiment("cell", argc, argv);
  Table table({"mode", "what", "mean [us]", "p50", "p99", "p99.9", "max", "RTF"});
  Plot plot{.title = "Default cell, both robots picking: time of a step",
            .x = {.label = "fraction of steps that take longer", .log = true},
            .y = {.label = "us", .log = true}};
  for (const auto& mode : kModes) {
    const bool ships = mode.value == kDefaultMode.value;
    const int steps = experiment.quick() ? 2000 : ships ? 30000 : 8000;
    const StepTimes rest = at_rest(mode, steps / 8);
    const StepTimes work = at_work(mode, steps, false);
    const StepTimes belt = at_work(mode, steps, true);
    row(table, mode.name, "at rest", rest.step, rest.real_time_factor(1e-3));
    row(table, mode.name, "both picking", work.step, work.real_time_factor(1e-3));
    row(table, mode.name, "picking, belt in between", belt.step, belt.real_time_factor(1e-3));
    if (!work.gripping.empty()) {
      row(table, mode.name, "both gripping", work.gripping, 1e3 / mean(work.gripping));
    }
    plot.series.push_back(distribution(mode.name, work.step));
    const std::string name = "cell." + std::string(mode.name);
    experiment.record(name + ".step_mean_us", mean(work.step), "us");
    experiment.record(name + ".rest_step_mean_us", mean(rest.step), "us");
    if (!ships) continue;
    experiment.record("cell.step_mean_us", mean(work.step), "us");
    experiment.record("cell.step_p99_us", percentile(work.step, 0.99), "us");
    experiment.record("cell.step_p999_us", percentile(work.step, 0.999), "us");
    experiment.record("cell.step_max_us", percentile(work.step, 1), "us");
    experiment.record("cell.publish_mean_us", mean(work.publish), "us");
    experiment.record("cell.rtf", work.real_time_factor(1e-3), "x");
    experiment.record("cell.trips", work.trips, "count");
  }
  ten_minutes(experiment);
  experiment.table("steps", "Default cell, time of World::step", table);
  experiment.plot("tails", plot);
  experiment.note(
      "Both robots carry gears between trays and kits all the time; RTF includes writing a "
      "snapshot "
      "after every step, the other columns are the step alone. Every time is of a single run, with "
      "what "
      "interrupted it. Ten minutes: both robots picking, the belt in between, CPU time of the "
      "thread.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
