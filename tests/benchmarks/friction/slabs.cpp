#include "tests/benchmarks/friction/slabs.hpp"

#include <numbers>

#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::bench {
namespace {

using Eigen::Vector3d;
using physics::test::Bench;

constexpr double kThickness = 0.015, kAbove = 1e-3;
constexpr double kFast = 0.5, kSlow = 0.05;  // growth of the load's share of its limit [1/s]
constexpr double kMostSeconds = 8;           // that any stage may take

scene::Scene scene_of(const SlabCase& c) {
  scene::Scene scene = physics::test::empty_scene();
  scene.physics.simplification = c.mode;
  scene.physics.step_s = kStep;
  scene.physics.friction.tray_ground = c.friction;
  scene.physics.friction.robot = 5;  // hand and slab
  physics::test::add_table(scene);
  scene::TrayType slab;
  slab.name = "slab";
  slab.min_xy = {-0.08, -0.06};
  slab.max_xy = {0.08, 0.06};
  slab.thickness_m = kThickness;
  slab.mass_kg = 0.2;
  scene.tray_types["slab"] = slab;
  physics::test::add_tray(scene, "slab", "slab", {0, 0}, {}, c.slab_yaw_rad);
  physics::test::add_hand(scene, {0, 0, kThickness + kAbove}, c.hand_yaw_rad);
  return scene;
}

class DraggedSlab {
 public:
  explicit DraggedSlab(const SlabCase& c)
      : case_(c),
        bench_(scene_of(c)),
        heading_(std::cos(c.heading_rad), std::sin(c.heading_rad), 0) {}

  void press() {
    bench_.run(50);
    bench_.grip(0);
    bench_.move({0, 0, -(kAbove + case_.press_m)}, 0.3);
    bench_.run(100);
  }
  /// One step of the hand along the heading, such that its mount's force grows by that share of
  /// the limit a second.
  void step(double share_per_s) {
    Eigen::Isometry3d next = bench_.X_WT;
    next.translation() += kStep * speed(share_per_s) * heading_;
    bench_.step_tool(next);
  }
  [[nodiscard]] double speed(double share_per_s) const {
    const double stiffness = bench_.scene.robots[0].gripper.palm_stiffness_n_m;
    return share_per_s * case_.friction * (stiffness * case_.press_m + weight_n()) / stiffness;
  }
  /// The load over its limit.
  [[nodiscard]] double share() const {
    Vector3d f = Vector3d::Zero();  // on the hand
    for (const auto& force : bench_.world->arm_forces(0)) {
      if (!force.relayed) f += force.f_W;
    }
    return f.head<2>().norm() / (case_.friction * (f.z() + weight_n()));
  }
  [[nodiscard]] Vector3d place() const { return bench_.X_WB("slab").translation(); }
  [[nodiscard]] std::uint64_t unsolved() const {
    return bench_.world->solver_failures().not_converged;
  }
  /// Way in the plane since a place.
  [[nodiscard]] double slip(const Vector3d& from) const {
    return (place() - from).head<2>().norm();
  }

 private:
  [[nodiscard]] double weight_n() const {
    return bench_.scene.tray_types.at("slab").mass_kg * bench_.scene.physics.gravity_m_s2;
  }

  SlabCase case_;
  Bench bench_;
  Vector3d heading_;
};

constexpr int kMostSteps = static_cast<int>(kMostSeconds / kStep);

/// Drags until the load has reached that share of its limit; whether it does.
bool raise(DraggedSlab& slab, double share, double share_per_s) {
  for (int i = 0; i < kMostSteps && slab.share() < share; ++i) slab.step(share_per_s);
  return slab.share() >= share;
}
void rest(DraggedSlab& slab, double seconds) {
  for (int i = 0; i < std::lround(seconds / kStep); ++i) slab.step(0);
}

/// Drags on slowly: the last load before the slab moves as fast as half the hand's speed, and
/// whether it ever does; then the greatest load while it slides.
void pass_limit(DraggedSlab& slab, Verdict& verdict) {
  bool slips = false;
  for (int i = 0; i < kMostSteps && !slips; ++i) {
    const Vector3d before = slab.place();
    const double share = slab.share();
    slab.step(kSlow);
    slips = slab.slip(before) > 0.5 * kStep * slab.speed(kSlow);
    if (!slips) verdict.onset = share;
  }
  double most = 0;
  for (int i = 0; i < 200; ++i) {
    slab.step(kSlow);
    most = std::max(most, slab.share());
  }
  verdict.false_hold = !slips || most > kAboveShare;
}

}  // namespace

Verdict drag(const SlabCase& the_case) {
  DraggedSlab slab(the_case);
  slab.press();
  Verdict verdict;
  if (!raise(slab, kCreepShare, kFast)) return {.onset = 0, .creep_m_s = 1, .false_drop = true};
  rest(slab, 0.1);
  const Vector3d at_first = slab.place();
  rest(slab, 0.2);
  verdict.creep_m_s = slab.slip(at_first) / 0.2;
  const Vector3d above = slab.place();
  const bool borne = raise(slab, kBelowShare, kSlow);
  rest(slab, 0.1);
  verdict.false_drop = !borne || slab.slip(above) > kNoSlip;
  pass_limit(slab, verdict);
  verdict.unsolved = slab.unsolved();
  return verdict;
}

SlabCase random_slab(std::mt19937_64& engine) {
  std::uniform_real_distribution<double> unit(0, 1);
  constexpr double kTurn = 2 * std::numbers::pi;
  SlabCase out;
  out.heading_rad = kTurn * unit(engine);
  out.slab_yaw_rad = kTurn * unit(engine);
  out.hand_yaw_rad = kTurn * unit(engine);
  out.friction = 0.15 + 0.65 * unit(engine);
  out.press_m = 5e-4 + 2e-3 * unit(engine);
  return out;
}

}  // namespace aprsim::bench
