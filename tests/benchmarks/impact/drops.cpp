#include "tests/benchmarks/impact/drops.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace aprsim::bench {
namespace {

constexpr double kStillSpeed = 1e-3;  // [m/s]
constexpr double kStillTurn = 1e-2;   // [rad/s]

Eigen::Quaterniond any_turn(std::mt19937_64& engine) {
  // Marsaglia 1972: uniform on the sphere of unit quaternions.
  std::normal_distribution<double> normal;
  const double w = normal(engine), x = normal(engine), y = normal(engine), z = normal(engine);
  return Eigen::Quaterniond(w, x, y, z).normalized();
}

}  // namespace

Falling::Falling(scene::Scene the_scene) : scene_(std::move(the_scene)), world_(scene_, {}, {}) {
  for (const auto& tray : scene_.trays) {
    masses_.push_back(physics::tray_mass(scene_.tray_types.at(tray.type)));
  }
  for (const auto& gear : scene_.gears) {
    masses_.push_back(physics::gear_mass(scene_.gear_types.at(gear.type)));
  }
}

double Falling::energy_j() const {
  double sum = 0;
  for (std::size_t i = 0; i < masses_.size(); ++i) {
    const auto state = world_.body(static_cast<int>(i));
    const auto& mass = masses_[i];
    const Eigen::Vector3d arm = state.q_WB * mass.com;
    const Eigen::Vector3d v = state.v_W + state.omega_W.cross(arm);
    const Eigen::Vector3d omega_B = state.q_WB.conjugate() * state.omega_W;
    sum += mass.mass_kg *
               (0.5 * v.squaredNorm() + scene_.physics.gravity_m_s2 * (state.p_WB + arm).z()) +
           0.5 * omega_B.dot(mass.inertia * omega_B);
  }
  return sum;
}

bool Falling::moves() const {
  for (int i = 0; i < world_.body_count(); ++i) {
    const auto state = world_.body(i);
    const Eigen::Vector3d arm = state.q_WB * masses_[static_cast<std::size_t>(i)].com;
    const Eigen::Vector3d v = state.v_W + state.omega_W.cross(arm);
    if (v.norm() > kStillSpeed || state.omega_W.norm() > kStillTurn) return true;
  }
  return false;
}

Drop drop(scene::Scene scene, double seconds, double rested_s) {
  const double step_s = scene.physics.step_s;
  Falling falling(std::move(scene));
  auto& world = falling.world();
  Drop out;
  double before = 0, least = 0;
  bool struck = false;
  const int steps = static_cast<int>(std::lround(seconds / step_s));
  for (int step = 1; step <= steps; ++step) {
    world.step();
    out.deepest_m = std::max(out.deepest_m, world.max_penetration_m());
    // While it falls the method's own error, g h v / 2 a second, is no gain of contacts.
    if (!struck) {
      struck = world.contact_count() > 0;
      before = least = falling.energy_j();
      continue;
    }
    const double energy = falling.energy_j();
    out.gained_j += std::max(0.0, energy - before);
    least = std::min(least, energy);
    out.risen_j = std::max(out.risen_j, energy - least);
    before = energy;
    if (falling.moves()) out.rest_s = step * step_s;
    if (step * step_s > out.rest_s + rested_s) break;
  }
  out.unsolved = world.solver_failures().not_converged;
  return out;
}

Pose random_pose(std::mt19937_64& engine, double clearance_m, double reach_m, double most_tilt) {
  std::uniform_real_distribution<double> unit(0, 1);
  Pose pose;
  if (most_tilt > std::numbers::pi) {
    pose.q = any_turn(engine);
  } else {
    const double heading = 2 * std::numbers::pi * unit(engine);
    const Eigen::Vector3d axis(std::cos(heading), std::sin(heading), 0);
    pose.q = Eigen::AngleAxisd(most_tilt * unit(engine), axis);
  }
  pose.p.z() = clearance_m + reach_m;
  return pose;
}

Pose upside_down(const Pose& pose) { return {pose.p, pose.q * Eigen::Quaterniond(0, 1, 0, 0)}; }

}  // namespace aprsim::bench
