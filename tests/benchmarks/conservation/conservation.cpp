// Energy and momentum against closed forms: a sliding block, a spinning cylinder, a spinning body
// in free flight, a stack and an overhanging block.

#include <cmath>

#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/modes.hpp"
#include "tests/benchmarks/trays/tray_run.hpp"
#include "world/physics/bodies/mass_properties.hpp"
#include "world/physics/physics_world.hpp"

namespace aprsim::bench {
namespace {

constexpr double kGravity = 9.81;
constexpr const char* kTrayType = "sku_small_gear_vessel";
constexpr const char* kGearType = "sku_part_medium_gear";

/// A belt at height 1 m and nothing else.
scene::Scene belt_at_one_metre(const Mode& mode) {
  scene::Scene scene = bare_belt(mode.value);
  scene.conveyor->X_WC.p = {0, 0, 1};
  return scene;
}

Pose at(double x, double y, double z) {
  Pose X;
  X.p = {x, y, z};
  return X;
}

/// A tray rides at 0.3 m/s when the belt stops at once: it slides v^2 / (2 mu g), and its energy
/// falls by mu m g a metre.
Series sliding_block(Experiment& experiment, const Mode& mode) {
  scene::Scene scene = belt_at_one_metre(mode);
  constexpr double kMu = 0.3;
  scene.physics.friction.tray_belt = kMu;
  const double thickness = scene.tray_types.at(kTrayType).thickness_m;
  scene.trays.push_back({.name = "block", .type = kTrayType, .X_WP = at(-1, 0, 1 + thickness)});
  physics::PhysicsWorld world(scene, {}, {});
  const double h = scene.physics.step_s;
  double speed = 0;
  for (int step = 0; step < 1000; ++step) {
    speed = std::min(0.3, speed + 0.5 * h);
    world.set_belt_speed(speed);
    world.step();
  }
  const auto start = world.body(0);
  const double v0 = start.v_W.x();
  world.set_belt_speed(0);
  double energy_error = 0;
  Series speeds{std::string(mode.name), {}};
  Table table({"time [s]", "speed [m/s]", "closed form [m/s]", "way [m]"});
  for (int step = 1; step <= 200; ++step) {
    world.step();
    const auto now = world.body(0);
    const double t = step * h, v = std::max(0.0, v0 - kMu * kGravity * t);
    const double way = now.p_WB.x() - start.p_WB.x();
    if (v > 0) {
      // In steps of h the way is shorter by mu g h t / 2 than in continuous time.
      const double whole_way = way + 0.5 * kMu * kGravity * h * t;
      const double lost = 0.5 * (v0 * v0 - now.v_W.x() * now.v_W.x()) - kMu * kGravity * whole_way;
      energy_error = std::max(energy_error, std::abs(lost) / (0.5 * v0 * v0));
    }
    if (step % 5 != 0) continue;
    table.row({t, now.v_W.x(), v, way});
    speeds.points.emplace_back(t, now.v_W.x());
  }
  const double way = world.body(0).p_WB.x() - start.p_WB.x() + 0.5 * h * v0;
  const double closed = v0 * v0 / (2 * kMu * kGravity);
  const std::string name = std::string("conservation.") + mode.name;
  experiment.record({name + ".slide_way_m", way, "m", "v^2 / (2 mu g)", way / closed});
  experiment.record(name + ".slide_way_error_m", std::abs(way - closed), "m");
  experiment.record(name + ".slide_energy_error", energy_error, "relative");
  experiment.table(std::string("slide_") + mode.name, "", table);
  return speeds;
}

/// Mean distance of the contact points from the gear's axis.
double contact_radius(const physics::PhysicsWorld& world) {
  std::vector<api::ContactSnapshot> contacts;
  world.write_contacts(contacts);
  const Eigen::Vector3d p = world.body(0).p_WB;
  double sum = 0;
  for (const auto& contact : contacts) sum += (contact.p_W - p).head<2>().norm();
  return sum / static_cast<double>(contacts.size());
}

/// A gear spins on the resting belt, on points at distance r from its axis: friction slows it by
/// alpha = mu m g r / I, so that it turns by omega^2 / (2 alpha), and takes mu m g r of its energy
/// a radian.
void spinning_cylinder(Experiment& experiment, const Mode& mode) {
  scene::Scene scene = belt_at_one_metre(mode);
  constexpr double kMu = 0.3, kSpin = 20;
  scene.physics.friction.gear_ground = kMu;
  const auto& type = scene.gear_types.at(kGearType);
  const auto mass = physics::gear_mass(type);
  scene.gears.push_back(
      {.name = "gear", .type = kGearType, .X_WP = at(0, 0, 1 + type.hub_height_m)});
  physics::PhysicsWorld world(scene, {}, {});
  for (int step = 0; step < 500; ++step) world.step();
  world.set_velocity(0, Eigen::Vector3d::Zero(), {0, 0, kSpin});
  const double h = scene.physics.step_s;
  double turn = 0, speed_error = 0, energy_error = 0, alpha = 0;
  for (int step = 1; step <= 1000; ++step) {
    world.step();
    if (step == 1) {
      alpha = kMu * mass.mass_kg * kGravity * contact_radius(world) / mass.inertia(2, 2);
    }
    const double omega = world.body(0).omega_W.z();
    turn += h * omega;
    const double closed = std::max(0.0, kSpin - alpha * step * h);
    speed_error = std::max(speed_error, std::abs(omega - closed) / kSpin);
    if (closed == 0) continue;
    // In steps of h the turn is smaller by alpha h t / 2 than in continuous time.
    const double whole_turn = turn + 0.5 * alpha * h * step * h;
    const double lost = 0.5 * (kSpin * kSpin - omega * omega) - alpha * whole_turn;
    energy_error = std::max(energy_error, std::abs(lost) / (0.5 * kSpin * kSpin));
  }
  turn += 0.5 * h * kSpin;
  const double closed = kSpin * kSpin / (2 * alpha);
  const std::string name = std::string("conservation.") + mode.name;
  experiment.record(
      {name + ".spin_turn_rad", turn, "rad", "omega^2 I / (2 mu m g r)", turn / closed});
  experiment.record(name + ".spin_speed_error", speed_error, "relative");
  experiment.record(name + ".spin_energy_error", energy_error, "relative");
}

struct Motion {
  Eigen::Vector3d p_com, v_com, angular_momentum;
  double spin_energy = 0;
};

Motion motion_of(const physics::BodyState& state, const physics::MassProperties& mass) {
  Motion out;
  const Eigen::Vector3d arm = state.q_WB * mass.com;
  out.p_com = state.p_WB + arm;
  out.v_com = state.v_W + state.omega_W.cross(arm);
  const Eigen::Matrix3d R = state.q_WB.toRotationMatrix();
  out.angular_momentum = R * mass.inertia * R.transpose() * state.omega_W;
  out.spin_energy = 0.5 * state.omega_W.dot(out.angular_momentum);
  return out;
}

/// A gear falls off the belt's end and tumbles: in flight its momentum changes by gravity alone,
/// its angular momentum and spin energy not at all.
void free_flight(Experiment& experiment, const Mode& mode) {
  scene::Scene scene = belt_at_one_metre(mode);
  const auto& type = scene.gear_types.at(kGearType);
  const auto mass = physics::gear_mass(type);
  scene.gears.push_back(
      {.name = "gear", .type = kGearType, .X_WP = at(1.3, 0.02, 1 + type.hub_height_m)});
  physics::PhysicsWorld world(scene, {}, {});
  const double h = scene.physics.step_s;
  double speed = 0;
  int flying = 0;
  for (int step = 0; step < 5000 && flying < 20; ++step) {
    speed = std::min(0.3, speed + 0.5 * h);
    world.set_belt_speed(speed);
    world.step();
    flying = world.contact_count() == 0 && world.body(0).p_WB.z() < 1 ? flying + 1 : 0;
  }
  const Motion start = motion_of(world.body(0), mass);
  double momentum = 0, angular = 0, energy = 0, fall = 0;
  for (int step = 1; step <= 300; ++step) {
    world.step();
    const Motion now = motion_of(world.body(0), mass);
    const double t = step * h;
    const Eigen::Vector3d v = start.v_com - Eigen::Vector3d(0, 0, kGravity * t);
    const Eigen::Vector3d p =
        start.p_com + t * start.v_com - Eigen::Vector3d(0, 0, 0.5 * kGravity * t * (t + h));
    momentum = std::max(momentum, (now.v_com - v).norm());
    fall = std::max(fall, (now.p_com - p).norm());
    angular = std::max(angular, (now.angular_momentum - start.angular_momentum).norm() /
                                    start.angular_momentum.norm());
    energy = std::max(energy, std::abs(now.spin_energy / start.spin_energy - 1));
  }
  const std::string name = std::string("conservation.") + mode.name;
  experiment.record(name + ".flight_speed_error_m_s", momentum, "m/s");
  experiment.record(name + ".flight_way_error_m", fall, "m");
  experiment.record(name + ".flight_angular_momentum_drift", angular, "relative");
  experiment.record(name + ".flight_spin_energy_drift", energy, "relative");
}

/// Five trays on each other: once they have settled they neither move nor sink.
void stack(Experiment& experiment, const Mode& mode) {
  scene::Scene scene = belt_at_one_metre(mode);
  const double thickness = scene.tray_types.at(kTrayType).thickness_m;
  constexpr int kTrays = 5;
  for (int i = 0; i < kTrays; ++i) {
    scene.trays.push_back({.name = "tray_" + std::to_string(i),
                           .type = kTrayType,
                           .X_WP = at(0, 0, 1 + thickness * (i + 1))});
  }
  physics::PhysicsWorld world(scene, {}, {});
  const auto energy = [&] {
    double kinetic = 0, potential = 0;
    for (int i = 0; i < kTrays; ++i) {
      const auto state = world.body(i);
      kinetic += 0.5 * state.v_W.squaredNorm();
      potential += kGravity * state.p_WB.z();
    }
    return std::pair{kinetic, potential};
  };
  for (int step = 0; step < 1000; ++step) world.step();
  const auto settled = energy();
  double kinetic = 0, potential = 0;
  for (int step = 0; step < 2000; ++step) {
    world.step();
    const auto now = energy();
    kinetic = std::max(kinetic, now.first);
    potential = std::max(potential, std::abs(now.second - settled.second));
  }
  const std::string name = std::string("conservation.") + mode.name;
  experiment.record(name + ".stack_kinetic_j_kg", kinetic, "J/kg");
  experiment.record(name + ".stack_potential_drift_j_kg", potential, "J/kg");
}

/// Whether a tray that overhangs the belt's side by that part of its half width stays.
bool stays(const Mode& mode, double overhang) {
  scene::Scene scene = belt_at_one_metre(mode);
  const auto& type = scene.tray_types.at(kTrayType);
  const double y = 0.5 * scene.conveyor->width_m + (overhang - 1) * type.max_xy.y();
  scene.trays.push_back(
      {.name = "tray", .type = kTrayType, .X_WP = at(0, y, 1 + type.thickness_m)});
  physics::PhysicsWorld world(scene, {}, {});
  for (int step = 0; step < 2000; ++step) {
    world.step();
    const auto state = world.body(0);
    if ((state.q_WB * Eigen::Vector3d::UnitZ()).z() < 0.99) return false;
  }
  return true;
}

/// It tips once its centre of mass is beyond the edge.
void overhang(Experiment& experiment, const Mode& mode) {
  double holds = 0.9, tips = 1.1;
  for (int i = 0; i < (experiment.quick() ? 5 : 9); ++i) {
    const double middle = 0.5 * (holds + tips);
    (stays(mode, middle) ? holds : tips) = middle;
  }
  const double onset = 0.5 * (holds + tips);
  experiment.record({std::string("conservation.") + mode.name + ".overhang_onset", onset,
                     "half widths", "closed form", onset});
}

int run(int argc, char** argv) {
  Experiment experiment("conservation", argc, argv);
  Plot plot{.title = "A tray slides on the belt that has stopped",
            .x = {.label = "time [s]"},
            .y = {.label = "speed [m/s]"}};
  for (const auto& mode : kModes) {
    if (experiment.quick() && mode.value != kDefaultMode.value) continue;
    plot.series.push_back(sliding_block(experiment, mode));
    spinning_cylinder(experiment, mode);
    free_flight(experiment, mode);
    stack(experiment, mode);
    overhang(experiment, mode);
  }
  experiment.plot("slide", plot);
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
