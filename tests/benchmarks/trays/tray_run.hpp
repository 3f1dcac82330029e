#pragma once

#include "tests/benchmarks/trays/tray_simulation.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::bench {

/// How long and how fast the Table 1 scene is run.
struct TrayRunPlan {
  double duration_s = 4;
  double settled_s = 0.5;  ///< the belt stands until then; reference of the settled figures
  double belt_speed_m_s = 0.3;
  double belt_accel_m_s2 = 0.5;
};

/// Sums over all gears, each relative to its tray (paper, eq. 6-7), and the time it took.
struct TrayRun {
  double delta_spawn_m = 0, delta_settled_m = 0;
  double theta_spawn_rad = 0, theta_settled_rad = 0;
  double cpu_s = 0;      ///< of the steps alone
  double steady_us = 0;  ///< a step, over the last second
  double contacts = 0;   ///< a step, mean
  double belt_travel_m = 0;
  double tray_travel_error_m = 0;  ///< largest difference of a tray's way to the belt's
  double deepest_m = 0;            ///< how far a gear has sunk into its tray
  double real_time_factor = 0;
};

/// The scene of that name from world/scenes, without random offsets.
scene::Scene shipped_scene(const std::string& name);

/// The belt of Table 1 with nothing on or under it.
scene::Scene bare_belt(scene::Simplification mode);

/// Turns every gear that sits in a slot about its axis and shifts it off its slot's centre, still
/// touching the tray's top face and clear of the pocket's wall. The same seed, the same places.
void disturb_gears(scene::Scene& scene, unsigned seed, double radius_m = 1.5e-4);

/// The belt's speed at a time: at rest, one ramp, then steady.
double belt_speed(const TrayRunPlan& plan, double t_s);

/// `simulation` must be of that scene and new. All poses are read after every step, as the daemon
/// does for its snapshots.
TrayRun run_trays(TraySimulation& simulation, const scene::Scene& scene, const TrayRunPlan& plan);
/// In our own physics.
TrayRun run_trays(const scene::Scene& scene, const TrayRunPlan& plan);

}  // namespace aprsim::bench
