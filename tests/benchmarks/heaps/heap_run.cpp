#include "tests/benchmarks/heaps/heap_run.hpp"

#include <algorithm>
#include <cmath>

#include "tests/benchmarks/support/clock.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "world/physics/physics_world.hpp"

namespace aprsim::bench {

HeapRun run_heap(const HeapPlan& plan, double from_s, double to_s) {
  const scene::Scene scene = heap_scene(plan);
  physics::PhysicsWorld world(scene, {}, {});
  HeapRun run;
  const double h = scene.physics.step_s;
  const auto steps = std::lround(to_s / h), first = std::lround(from_s / h);
  std::uint64_t newton_before = 0, unsolved_before = 0;
  for (long i = 0; i < steps; ++i) {
    if (i == first) {
      newton_before = world.solver_work().iterations;
      unsolved_before = world.solver_failures().not_converged;
    }
    const double start = 1e6 * thread_cpu_s();
    world.step();
    const double us = 1e6 * thread_cpu_s() - start;
    run.deepest_m = std::max(run.deepest_m, world.max_penetration_m());
    if (i < first) continue;
    run.step_us.push_back(us);
    run.contacts += world.contact_count();
  }
  const auto timed = static_cast<double>(run.step_us.size());
  run.contacts /= timed;
  run.newton_steps = static_cast<double>(world.solver_work().iterations - newton_before) / timed;
  run.unsolved = static_cast<double>(world.solver_failures().not_converged - unsolved_before);
  run.worst_residual_m_s = world.solver_failures().max_residual_m_s;
  for (int body = 0; body < world.body_count(); ++body) run.lost += world.lost(body);
  return run;
}

double growth_exponent(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<double> log_x, log_y;
  for (const double value : x) log_x.push_back(std::log(value));
  for (const double value : y) log_y.push_back(std::log(value));
  const double mean_x = mean(log_x), mean_y = mean(log_y);
  double xy = 0, xx = 0;
  for (std::size_t i = 0; i < log_x.size(); ++i) {
    xy += (log_x[i] - mean_x) * (log_y[i] - mean_y);
    xx += (log_x[i] - mean_x) * (log_x[i] - mean_x);
  }
  return xy / xx;
}

}  // namespace aprsim::bench
