#include "tests/benchmarks/awake/jolt_model.hpp"

#include <cmath>

#include "tests/benchmarks/peers/peer_geometry.hpp"
#include "world/physics/bodies/mass_properties.hpp"

namespace aprsim::bench {
namespace {

using Eigen::Vector3d;
using Json = nlohmann::json;

constexpr double kBeltDepth = 0.1;  // [m]

Json numbers(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Json numbers(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

Json box(const Vector3d& at, const Vector3d& half) {
  return {{"at", numbers(at)}, {"half", numbers(half)}};
}
/// Axis z, from `low` to `high`.
Json cone(const Vector3d& origin, double low, double high, double low_radius, double high_radius) {
  return {{"at", numbers(Vector3d(origin + Vector3d(0, 0, 0.5 * (low + high))))},
          {"half_height", 0.5 * (high - low)},
          {"low_radius", low_radius},
          {"high_radius", high_radius}};
}

Json fixed_body(const char* motion, const char* surface, const Pose& X_WS, const Vector3d& half) {
  return {{"motion", motion},
          {"surface", surface},
          {"p", numbers(X_WS.p)},
          {"q", numbers(X_WS.q)},
          {"shapes", {box(Vector3d::Zero(), half)}}};
}

Json free_body(const char* surface, const Pose& X_WB, const physics::MassProperties& mass,
               Json shapes) {
  return {{"motion", "free"},
          {"surface", surface},
          {"p", numbers(Vector3d(X_WB.p + X_WB.q * mass.com))},
          {"q", numbers(X_WB.q)},
          {"com", numbers(mass.com)},
          {"mass", mass.mass_kg},
          {"inertia", numbers(Vector3d(mass.inertia.diagonal()))},
          {"shapes", std::move(shapes)}};
}

/// Relative to the centre of mass, as all shapes of bodies.
Json tray_shapes(const scene::TrayType& type, const Vector3d& com) {
  Json out = Json::array();
  for (const auto& part : tray_boxes(type)) out.push_back(box(part.centre - com, part.half));
  return out;
}
Json gear_shapes(const scene::GearType& type, const Vector3d& com) {
  Json out = {cone(-com, 0, type.disc_height_m, type.disc_radius_m, type.disc_radius_m),
              cone(-com, -type.hub_height_m, 0, type.hub_bottom_radius_m, type.hub_top_radius_m)};
  if (type.peg_top_m > type.disc_height_m) {
    out.push_back(
        cone(-com, type.disc_height_m, type.peg_top_m, type.peg_radius_m, type.peg_radius_m));
  }
  return out;
}

/// Coulomb's coefficients by Jolt's rule: that of a pair is the root of the product of both. The
/// pairs gear and tray, tray and belt, gear and gear are exact.
Json frictions(const scene::SurfacePairs& mu) {
  const double gear = mu.gear_gear, tray = mu.gear_tray * mu.gear_tray / gear;
  return {{"gear", gear},
          {"tray", tray},
          {"belt", mu.tray_belt * mu.tray_belt / tray},
          {"ground", mu.tray_ground * mu.tray_ground / tray}};
}

}  // namespace

nlohmann::json jolt_model(const scene::Scene& scene, const JoltSettings& settings) {
  Json bodies = Json::array();
  for (const auto& fixed : scene.fixed) {
    bodies.push_back(fixed_body("fixed", "ground", fixed.X_WS, 0.5 * fixed.size));
  }
  if (scene.conveyor) {
    const auto& belt = *scene.conveyor;
    Pose X_WS = belt.X_WC;
    X_WS.p -= X_WS.q * Vector3d(0, 0, 0.5 * kBeltDepth);
    const Vector3d half(3 * belt.length_m, belt.width_m, 0.5 * kBeltDepth);
    bodies.push_back(fixed_body("belt", "belt", X_WS, half));
  }
  for (const auto& tray : scene.trays) {
    const auto& type = scene.tray_types.at(tray.type);
    const auto mass = physics::tray_mass(type);
    bodies.push_back(free_body("tray", tray.X_WP, mass, tray_shapes(type, mass.com)));
  }
  for (const auto& gear : scene.gears) {
    const auto& type = scene.gear_types.at(gear.type);
    const auto mass = physics::gear_mass(type);
    bodies.push_back(free_body("gear", gear.X_WP, mass, gear_shapes(type, mass.com)));
  }
  return {{"step_s", scene.physics.step_s},
          {"gravity", scene.physics.gravity_m_s2},
          {"friction", frictions(scene.physics.friction)},
          {"convex_radius", 1e-4},
          {"settings",
           {{"mNumVelocitySteps", settings.velocity_steps},
            {"mNumPositionSteps", settings.position_steps},
            {"mSpeculativeContactDistance", 1e-3},
            {"mPenetrationSlop", 1e-5},
            {"mManifoldTolerance", 1e-4},
            {"mBodyPairCacheMaxDeltaPositionSq", 1e-8},
            {"mBodyPairCacheCosMaxDeltaRotationDiv2", std::cos(1e-3)},
            {"mContactPointPreserveLambdaMaxDistSq", 1e-6}}},
          {"bodies", std::move(bodies)}};
}

}  // namespace aprsim::bench
