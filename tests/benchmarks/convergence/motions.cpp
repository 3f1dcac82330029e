#include "tests/benchmarks/convergence/motions.hpp"

#include <cmath>
#include <limits>

#include "tests/benchmarks/turning/held_part.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::bench {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kGravity = 9.81;
constexpr double kSettling = 0.2;                                  // [s]
constexpr double kRolls = 0.512, kSlides = 0.512, kSpins = 0.256;  // [s]: all in whole steps

double between(std::mt19937_64& engine, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(engine);
}

void run(physics::test::Bench& bench, double seconds) {
  bench.run(static_cast<int>(std::lround(seconds / bench.scene.physics.step_s)));
}

scene::Scene scene_of(double step_s, double friction) {
  scene::Scene scene = physics::test::empty_scene();
  scene.physics.step_s = step_s;
  scene.physics.simplification = scene::Simplification::kOff;
  scene.physics.friction.gear_ground = scene.physics.friction.tray_ground = friction;
  return scene;
}

scene::GearType disc_of(double radius_m, double height_m) {
  scene::GearType type;
  type.name = "disc";
  type.disc_radius_m = radius_m;
  type.disc_height_m = type.peg_top_m = height_m;
  type.mass_kg = 0.1;
  return type;
}

}  // namespace

HeldMotion::HeldMotion(std::mt19937_64& engine, bool midway)
    : seed_(static_cast<unsigned>(engine())), midway_(midway) {}

Vector3d HeldMotion::simulated(double step_s) const {
  std::mt19937_64 engine(seed_);
  const Turn turn = random_turn(engine);
  HeldPart part({.grasp = Grasp::kFlatPads,
                 .mode = scene::Simplification::kOff,
                 .step_s = step_s,
                 .gravity_m_s2 = 0});
  const Isometry3d place = part.place();
  part.turn(turn, 1, midway_ ? 0.5 : 1);
  if (!midway_) part.rest(kSettling);
  return (place.inverse() * part.place()).translation();
}

Vector3d HeldMotion::closed_form() const {
  return midway_ ? Vector3d::Constant(std::numeric_limits<double>::quiet_NaN())
                 : Vector3d(Vector3d::Zero());
}

RollingMotion::RollingMotion(std::mt19937_64& engine)
    : radius_m_(between(engine, 0.01, 0.04)),
      length_m_(between(engine, 1, 3) * radius_m_),
      slope_rad_(between(engine, 0.05, 0.4)),
      speed_m_s_(between(engine, 0.05, 0.3)) {}

Vector3d RollingMotion::simulated(double step_s) const {
  scene::Scene scene = scene_of(step_s, 1);
  Isometry3d X_WS = Isometry3d::Identity();
  X_WS.linear() = Eigen::AngleAxisd(slope_rad_, Vector3d::UnitY()).toRotationMatrix();
  const Vector3d along = X_WS.linear().col(0), normal = X_WS.linear().col(2);
  Isometry3d X_WP = X_WS;
  X_WP.translation() = -0.025 * normal;
  scene.fixed.push_back({"slope", {4, 1, 0.05}, Pose::from(X_WP)});
  scene.gear_types["disc"] = disc_of(radius_m_, length_m_);
  Isometry3d X_WB = Isometry3d::Identity();
  X_WB.linear().col(2) = Vector3d::UnitY();
  X_WB.linear().col(0) = normal;
  X_WB.linear().col(1) = X_WB.linear().col(2).cross(normal);
  X_WB.translation() = radius_m_ * normal;
  physics::test::add_gear(scene, "roller", "disc", Pose::from(X_WB));
  physics::test::Bench bench(std::move(scene));
  const Vector3d start = bench.X_WB("roller").translation();
  bench.world->set_velocity(0, speed_m_s_ * along, speed_m_s_ / radius_m_ * Vector3d::UnitY());
  run(bench, kRolls);
  return {(bench.X_WB("roller").translation() - start).dot(along), 0, 0};
}

/// The mass of a solid cylinder counts one and a half times.
Vector3d RollingMotion::closed_form() const {
  const double accel = kGravity * std::sin(slope_rad_) / 1.5;
  return {speed_m_s_ * kRolls + 0.5 * accel * kRolls * kRolls, 0, 0};
}

SlidingMotion::SlidingMotion(std::mt19937_64& engine)
    : friction_(between(engine, 0.1, 0.4)), speed_m_s_(between(engine, 0.3, 1)) {}

Vector3d SlidingMotion::simulated(double step_s) const {
  scene::Scene scene = scene_of(step_s, friction_);
  physics::test::add_table(scene);
  physics::test::add_tray(scene, "slab", "small4", {-0.5, 0}, {});
  physics::test::Bench bench(std::move(scene));
  run(bench, kSettling);
  const double start = bench.X_WB("slab").translation().x();
  bench.world->set_velocity(0, {speed_m_s_, 0, 0}, Vector3d::Zero());
  run(bench, kSlides);
  return {bench.X_WB("slab").translation().x() - start, 0, 0};
}

Vector3d SlidingMotion::closed_form() const {
  const double decel = friction_ * kGravity;
  const double seconds = std::min(kSlides, speed_m_s_ / decel);
  return {speed_m_s_ * seconds - 0.5 * decel * seconds * seconds, 0, 0};
}

SpinningMotion::SpinningMotion(std::mt19937_64& engine)
    : radius_m_(between(engine, 0.02, 0.05)),
      friction_(between(engine, 0.1, 0.3)),
      rate_rad_s_(between(engine, 40, 60)) {}

Vector3d SpinningMotion::simulated(double step_s) const {
  scene::Scene scene = scene_of(step_s, friction_);
  physics::test::add_table(scene);
  scene.gear_types["disc"] = disc_of(radius_m_, 0.01);
  physics::test::add_gear(scene, "disc", "disc", {});
  physics::test::Bench bench(std::move(scene));
  run(bench, kSettling);
  bench.world->set_velocity(0, Vector3d::Zero(), {0, 0, rate_rad_s_});
  double angle = 0;
  Vector3d before = bench.X_WB("disc").linear().col(0);
  for (long left = std::lround(kSpins / step_s); left > 0; --left) {
    bench.run(1);
    const Vector3d now = bench.X_WB("disc").linear().col(0);
    angle += std::atan2(before.x() * now.y() - before.y() * now.x(), before.dot(now));
    before = now;
  }
  return {angle, 0, 0};
}

/// The model presses with the rim of a face, with a torque of mu N R; half m R^2 is the moment of
/// inertia.
Vector3d SpinningMotion::closed_form() const {
  const double decel = 2 * friction_ * kGravity / radius_m_;
  const double seconds = std::min(kSpins, rate_rad_s_ / decel);
  return {rate_rad_s_ * seconds - 0.5 * decel * seconds * seconds, 0, 0};
}

}  // namespace aprsim::bench
