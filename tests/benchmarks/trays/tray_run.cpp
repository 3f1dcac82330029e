#include "tests/benchmarks/trays/tray_run.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "tests/benchmarks/support/clock.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::bench {
namespace {

/// Which tray each gear of the scene sits in: index of the tray, by index of the gear.
std::vector<int> trays_of_gears(const scene::Scene& scene) {
  std::vector<int> out(scene.gears.size(), -1);
  for (std::size_t t = 0; t < scene.trays.size(); ++t) {
    for (const auto& [slot, gear] : scene.trays[t].gears) {
      for (std::size_t g = 0; g < scene.gears.size(); ++g) {
        if (scene.gears[g].name == gear) out[g] = static_cast<int>(t);
      }
    }
  }
  return out;
}

/// Poses of all gears relative to their trays.
std::vector<Pose> relative_poses(const TraySimulation& simulation, const std::vector<int>& trays,
                                 int tray_count) {
  std::vector<Pose> out;
  for (std::size_t g = 0; g < trays.size(); ++g) {
    const Pose tray = simulation.body(trays[g]);
    const Pose gear = simulation.body(tray_count + static_cast<int>(g));
    const Eigen::Quaterniond q_PW = tray.q.conjugate();
    out.push_back({q_PW * (gear.p - tray.p), q_PW * gear.q});
  }
  return out;
}

/// Eq. 6-7 summed over all gears; the angle by the form that resolves small ones.
void sum_motion(const std::vector<Pose>& from, const std::vector<Pose>& to, double& delta_m,
                double& theta_rad) {
  delta_m = theta_rad = 0;
  for (std::size_t g = 0; g < from.size(); ++g) {
    delta_m += (to[g].p - from[g].p).norm();
    const Eigen::Quaterniond turn = from[g].q.conjugate() * to[g].q;
    theta_rad += 2 * std::atan2(turn.vec().norm(), std::abs(turn.w()));
  }
}

}  // namespace

scene::Scene shipped_scene(const std::string& name) {
  auto scene = scene::load_scene(name, scene::default_data_paths());
  if (!scene) throw std::runtime_error(scene.error().message);
  return std::move(*scene);
}

scene::Scene bare_belt(scene::Simplification mode) {
  scene::Scene scene = shipped_scene("table1");
  scene.trays.clear();
  scene.gears.clear();
  scene.fixed.clear();
  scene.floor = false;
  scene.physics.simplification = mode;
  return scene;
}

void disturb_gears(scene::Scene& scene, unsigned seed, double radius_m) {
  std::mt19937 random(seed);
  // Own scaling: the standard library's distributions differ between implementations.
  const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
  for (auto& gear : scene.gears) {
    const double direction = 2 * M_PI * uniform(), distance = radius_m * std::sqrt(uniform());
    gear.X_WP.p += distance * Eigen::Vector3d(std::cos(direction), std::sin(direction), 0);
    const Eigen::AngleAxisd turn(2 * M_PI * uniform(), Eigen::Vector3d::UnitZ());
    gear.X_WP.q = gear.X_WP.q * Eigen::Quaterniond(turn);
  }
}

double belt_speed(const TrayRunPlan& plan, double t_s) {
  return std::clamp((t_s - plan.settled_s) * plan.belt_accel_m_s2, 0.0, plan.belt_speed_m_s);
}

TrayRun run_trays(TraySimulation& simulation, const scene::Scene& scene, const TrayRunPlan& plan) {
  const auto trays = trays_of_gears(scene);
  const int tray_count = static_cast<int>(scene.trays.size());
  const double h = scene.physics.step_s;
  const int steps = static_cast<int>(std::lround(plan.duration_s / h));
  const int settled = static_cast<int>(std::lround(plan.settled_s / h));
  const int steady = steps - static_cast<int>(std::lround(std::min(1.0, plan.duration_s / 4) / h));
  const auto spawn = relative_poses(simulation, trays, tray_count);
  std::vector<double> tray_start_x;
  for (int t = 0; t < tray_count; ++t) tray_start_x.push_back(simulation.body(t).p.x());
  auto rest = spawn;
  TrayRun run;
  const int bodies = tray_count + static_cast<int>(scene.gears.size());
  Eigen::Vector3d read = Eigen::Vector3d::Zero();
  const double start = thread_cpu_s();
  double left_out = 0, steady_start = start;
  for (int step = 0; step < steps; ++step) {
    if (step == settled) {
      const double pause = thread_cpu_s();
      rest = relative_poses(simulation, trays, tray_count);
      left_out = thread_cpu_s() - pause;
    }
    if (step == steady) steady_start = thread_cpu_s();
    const double speed = belt_speed(plan, (step + 1) * h);
    simulation.step(speed);
    run.belt_travel_m += speed * h;
    run.contacts += simulation.contact_count();
    for (int body = 0; body < bodies; ++body) read += simulation.body(body).p;
  }
  const double end = thread_cpu_s();
  run.cpu_s = end - start - left_out;
  run.steady_us = 1e6 * (end - steady_start) / (steps - steady);
  run.contacts /= steps;
  if (!read.allFinite()) throw std::runtime_error("a body is nowhere");
  run.real_time_factor = plan.duration_s / run.cpu_s;
  const auto last = relative_poses(simulation, trays, tray_count);
  sum_motion(spawn, last, run.delta_spawn_m, run.theta_spawn_rad);
  sum_motion(rest, last, run.delta_settled_m, run.theta_settled_rad);
  for (std::size_t t = 0; t < tray_start_x.size(); ++t) {
    const double way = simulation.body(static_cast<int>(t)).p.x() - tray_start_x[t];
    run.tray_travel_error_m = std::max(run.tray_travel_error_m, std::abs(way - run.belt_travel_m));
  }
  for (std::size_t g = 0; g < last.size(); ++g) {
    run.deepest_m = std::max(run.deepest_m, spawn[g].p.z() - last[g].p.z());
  }
  return run;
}

TrayRun run_trays(const scene::Scene& scene, const TrayRunPlan& plan) {
  const auto simulation = own_simulation(scene);
  return run_trays(*simulation, scene, plan);
}

}  // namespace aprsim::bench
