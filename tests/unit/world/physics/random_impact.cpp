#include "tests/unit/world/physics/random_impact.hpp"

#include <algorithm>
#include <array>
#include <random>
#include <span>

#include "tests/unit/world/physics/cell_builder.hpp"
#include "tests/unit/world/physics/random_part.hpp"
#include "world/physics/bodies/mass_properties.hpp"
#include "world/scene/model/pieces.hpp"

namespace aprsim::physics::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kApart_m = 0.3;  // between the origins before
constexpr int kMostSteps = 400;
constexpr int kStepsBehind = 40;  // after the last contact

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  Vector3d direction() {
    const Vector3d v(normal_(engine_), normal_(engine_), normal_(engine_));
    return v.normalized();
  }
  Quaterniond attitude() {
    const double w = normal_(engine_), x = normal_(engine_), y = normal_(engine_);
    return Quaterniond(w, x, y, normal_(engine_)).normalized();
  }
  bool chance(double share) { return between(0, 1) < share; }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
};

/// Sums over the two bodies.
struct Momenta {
  double energy_j = 0;
  Vector3d linear = Vector3d::Zero(), angular = Vector3d::Zero();
  double linear_size = 0, angular_size = 0;
};

Momenta momenta_of(const PhysicsWorld& world, const std::array<MassProperties, 2>& masses) {
  Momenta out;
  std::array<Vector3d, 2> com, v;
  Vector3d centre = Vector3d::Zero(), drift = Vector3d::Zero();
  double kg = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    const BodyState body = world.body(static_cast<int>(i));
    const Vector3d arm = body.q_WB * masses[i].com;
    com[i] = body.p_WB + arm;
    v[i] = body.v_W + body.omega_W.cross(arm);
    centre += masses[i].mass_kg * com[i];
    drift += masses[i].mass_kg * v[i];
    kg += masses[i].mass_kg;
  }
  centre /= kg;
  drift /= kg;
  for (std::size_t i = 0; i < 2; ++i) {
    const BodyState body = world.body(static_cast<int>(i));
    const Eigen::Matrix3d R = body.q_WB.normalized().toRotationMatrix();
    const Vector3d spin = R * (masses[i].inertia * (R.transpose() * body.omega_W));
    const Vector3d orbit = masses[i].mass_kg * (com[i] - centre).cross(v[i] - drift);
    out.energy_j += 0.5 * (masses[i].mass_kg * v[i].squaredNorm() + body.omega_W.dot(spin));
    out.linear += masses[i].mass_kg * v[i];
    out.linear_size += masses[i].mass_kg * v[i].norm();
    out.angular += spin + orbit;
    out.angular_size += spin.norm() + orbit.norm();
  }
  return out;
}

/// Cuts the corners of each type of tray by different shares of its half edge.
void cut_corners(scene::Scene& scene) {
  for (auto& [name, type] : scene.tray_types) {
    const double h = type.max_xy.x();
    type.outline = scene::outline_of({{-0.9 * h, -h},
                                      {0.8 * h, -h},
                                      {h, -0.8 * h},
                                      {h, 0.7 * h},
                                      {0.7 * h, h},
                                      {-h, h},
                                      {-h, -0.9 * h}});
  }
}

/// Adds a part of one or two random pieces, which touch; returns its mass properties.
MassProperties add_pieces(scene::Scene& scene, std::uint64_t seed, const std::string& name,
                          const Pose& X) {
  constexpr double kRadius_m = 0.03;
  std::mt19937_64 random(seed + 1);
  const auto pick = [&] {
    const auto number = std::uniform_int_distribution<int>(0, kPieceShapes - 1)(random);
    return random_piece(static_cast<PieceShape>(number), kRadius_m, random);
  };
  std::vector<api::Piece> pieces{pick()};
  if (random() % 2 == 0) {
    pieces.push_back(pick());
    const double top = scene::bounds_of(std::span(pieces).first(1)).max().z();
    pieces.back().X_BP.p.z() = top - scene::bounds_of(std::span(pieces).last(1)).min().z();
  }
  const scene::PartType type = part_type(name, pieces, 0.2);
  add_part(scene, name, type, X);
  return {type.mass_kg, type.com, type.inertia};
}

/// Adds a body of a random type; returns its mass properties.
MassProperties add_body(scene::Scene& scene, Dice& dice, const std::string& name, const Pose& X) {
  if (dice.chance(0.3)) {
    static constexpr std::array kTrays = {"small4", "medium4", "d504", "d604"};
    const char* type = kTrays[static_cast<std::size_t>(dice.between(0, 4))];
    scene.trays.push_back({.name = name, .type = type, .X_WP = X});
    return tray_mass(scene.tray_types.at(type));
  }
  static constexpr std::array kGears = {"small", "medium", "large", "d50", "d60"};
  const char* type = kGears[static_cast<std::size_t>(dice.between(0, 5))];
  add_gear(scene, name, type, X);
  return gear_mass(scene.gear_types.at(type));
}

}  // namespace

ImpactOutcome random_impact(std::uint64_t seed, const ImpactRange& range) {
  Dice dice(seed);
  scene::Scene scene = empty_scene();
  if (range.outlines) cut_corners(scene);
  scene.physics.gravity_m_s2 = 0;
  scene.physics.simplification = scene::Simplification::kOff;
  scene.physics.residual_m_s = range.max_residual_m_s;
  const double e = dice.between(0, range.max_restitution);
  const double mu = dice.between(0, range.max_friction);
  scene.physics.restitution = {e, e, e, e, e, e, e};
  scene.physics.friction = {mu, mu, mu, mu, mu, mu, mu};
  Pose first, second;
  first.q = dice.attitude();
  second.q = dice.attitude();
  // Coplanar discs, whose rims meet, are a case of their own.
  if (dice.chance(0.2)) second.q = first.q;
  const Vector3d apart = dice.direction();
  second.p = kApart_m * apart + dice.between(0, 0.05) * dice.direction();
  if (second.q.isApprox(first.q) && dice.chance(0.5)) {
    const Vector3d axis = first.q * Vector3d::UnitZ();
    second.p -= second.p.dot(axis) * axis;
    second.p = kApart_m * second.p.normalized();
  }
  std::array<MassProperties, 2> masses;
  // Trays come first among the bodies.
  masses[0] = range.parts ? add_pieces(scene, seed, "a", first) : add_body(scene, dice, "a", first);
  masses[1] = range.parts && dice.chance(0.7) ? add_pieces(scene, seed + 1, "b", second)
                                              : add_body(scene, dice, "b", second);
  // Trays come first, then gears, then parts.
  const bool swapped = (scene.trays.size() == 1 && scene.trays[0].name == "b") ||
                       (scene.parts.size() == 1 && scene.gears.size() == 1);
  if (swapped) std::swap(masses[0], masses[1]);
  Bench bench(std::move(scene));
  PhysicsWorld& world = *bench.world;
  const double speed = dice.between(0.1, range.max_speed_m_s);
  const Vector3d common = dice.between(0, 1) * dice.direction();

  const auto spin = [&]() -> Vector3d {
    return dice.between(0, range.max_omega_rad_s) * dice.direction();
  };
  const Vector3d towards = second.p.normalized();
  world.set_velocity(swapped ? 1 : 0, common + 0.5 * speed * towards, spin());
  world.set_velocity(swapped ? 0 : 1, common - 0.5 * speed * towards, spin());
  const Momenta before = momenta_of(world, masses);
  ImpactOutcome out;
  int last_touch = 0;
  std::vector<api::ContactSnapshot> contacts;
  for (int step = 0; step < kMostSteps; ++step) {
    world.step();
    contacts.clear();
    world.write_contacts(contacts);
    for (const auto& contact : contacts) {
      if (contact.f_W.isZero(0)) continue;
      out.touched = true;
      last_touch = step;
    }
    const Momenta now = momenta_of(world, masses);
    out.energy_ratio = std::max(out.energy_ratio, now.energy_j / before.energy_j);
    out.momentum_error =
        std::max(out.momentum_error, (now.linear - before.linear).norm() / before.linear_size);
    out.angular_momentum_error = std::max(
        out.angular_momentum_error, (now.angular - before.angular).norm() / before.angular_size);
    if (out.touched && step > last_touch + kStepsBehind) break;
    if (!out.touched && step > 1.5 * kApart_m / speed / 1e-3) break;
  }
  return out;
}

}  // namespace aprsim::physics::test
