// Real-time factor of the whole default cell, as fast as one core steps it.

#include <memory>

#include <benchmark/benchmark.h>

#include "tests/support/cell_script.hpp"

namespace aprsim::test {
namespace {

constexpr int kStepsAnIteration = 1000;

void report(benchmark::State& state, const CellScript& cell) {
  const double simulated_s =
      static_cast<double>(state.iterations()) * kStepsAnIteration * seconds(cell.world.step_size());
  state.counters["real_time_factor"] = benchmark::Counter(simulated_s, benchmark::Counter::kIsRate);
  state.counters["us_per_step"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * kStepsAnIteration * 1e-6,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void step(benchmark::State& state, CellScript& cell) {
  api::Snapshot snapshot;
  for (auto unused : state) {
    for (int i = 0; i < kStepsAnIteration; ++i) {
      cell.world.step();
      cell.world.write(snapshot);  // published every step, as the daemon does
    }
  }
  report(state, cell);
}

/// Robots still, belt still.
void at_rest(benchmark::State& state, const char* scene) {
  CellScript cell(load_scene(scene));
  cell.advance(1000);
  step(state, cell);
}

/// The belt runs back and forth under its trays, both arms sweep over them.
void at_work(benchmark::State& state, const char* scene) {
  CellScript cell(load_scene(scene));
  cell.advance(1000);
  const int robots = static_cast<int>(cell.world.description()->robots.size());
  for (int robot = 0; robot < robots; ++robot) {
    cell.world.apply(1, api::RobotCommand{robot, api::InitRobot{}});
  }
  api::Snapshot snapshot;
  double side = 1;
  for (auto unused : state) {
    side = -side;
    cell.world.apply(1, api::ConveyorCommand{.run = true, .forward = side > 0, .speed_m_s = 0.1});
    for (int robot = 0; robot < robots; ++robot) {
      cell.world.apply(
          1, api::RobotCommand{robot, api::MoveJoints{{{.joint = 0, .position_rad = 0.2 * side}}}});
    }
    for (int i = 0; i < kStepsAnIteration; ++i) {
      cell.world.step();
      cell.world.write(snapshot);
    }
  }
  report(state, cell);
}

BENCHMARK_CAPTURE(at_rest, aprs, "aprs")->Unit(benchmark::kMillisecond)->MinTime(3);
BENCHMARK_CAPTURE(at_work, aprs, "aprs")->Unit(benchmark::kMillisecond)->MinTime(5);
BENCHMARK_CAPTURE(at_rest, table1, "table1")->Unit(benchmark::kMillisecond)->MinTime(3);
BENCHMARK_CAPTURE(at_work, table1, "table1")->Unit(benchmark::kMillisecond)->MinTime(5);

}  // namespace
}  // namespace aprsim::test

BENCHMARK_MAIN();
