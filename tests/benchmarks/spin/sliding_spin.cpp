#include "tests/benchmarks/spin/sliding_spin.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "tests/unit/world/physics/cell_builder.hpp"
#include "world/physics/bodies/mass_properties.hpp"

namespace aprsim::bench {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using physics::test::Bench;

constexpr double kFine = 1e-5, kGravity = 9.81;
constexpr double kSettled = 0.6, kMost = 5;  // [s]
constexpr const char* kTray = "small4";

scene::Scene scene_of(const SpinCase& c) {
  scene::Scene scene = physics::test::empty_scene();
  scene.physics.simplification = c.mode;
  scene.physics.step_s = c.step_s;
  scene.physics.friction.tray_ground = c.friction;
  physics::test::add_table(scene);
  physics::test::add_tray(scene, "tray", kTray, {0, 0}, {}, c.tray_yaw_rad);
  return scene;
}

struct Planar {
  Vector2d p = Vector2d::Zero(), v = Vector2d::Zero();
  double yaw = 0, spin = 0;

  [[nodiscard]] Planar moved(const Planar& rate, double t) const {
    return {p + t * rate.p, v + t * rate.v, yaw + t * rate.yaw, spin + t * rate.spin};
  }
};

/// The reference of slide_and_spin.
class SlidingBody {
 public:
  /// `points` of touch from the centre of mass, which is `height_m` over them, at yaw 0.
  SlidingBody(std::vector<Vector2d> points, double height_m, const physics::MassProperties& mass,
              double friction)
      : points_(std::move(points)), height_m_(height_m), mass_(mass), friction_(friction) {}

  /// The state after a time.
  [[nodiscard]] Planar after(Planar state, double seconds) const {
    for (long left = std::lround(seconds / kFine); left > 0; --left) state = next(state);
    return state;
  }
  [[nodiscard]] Planar rest_from(Planar state) const {
    for (double before = energy(state); before > 0;) {
      const Planar later = next(state);
      if (energy(later) >= before) break;  // it rests within this step
      state = later;
      before = energy(state);
    }
    return state;
  }

 private:
  /// A fine step with the method of Runge and Kutta.
  [[nodiscard]] Planar next(const Planar& state) const {
    const Planar k1 = rate(state), k2 = rate(state.moved(k1, 0.5 * kFine)),
                 k3 = rate(state.moved(k2, 0.5 * kFine)), k4 = rate(state.moved(k3, kFine));
    return state.moved(k1, kFine / 6)
        .moved(k2, kFine / 3)
        .moved(k3, kFine / 3)
        .moved(k4, kFine / 6);
  }
  [[nodiscard]] double energy(const Planar& s) const {
    return 0.5 * mass_.mass_kg * s.v.squaredNorm() + 0.5 * mass_.inertia(2, 2) * s.spin * s.spin;
  }
  [[nodiscard]] Planar rate(const Planar& s) const {
    const Eigen::Rotation2Dd turn(s.yaw);
    std::vector<Vector2d> levers, along;  // of the points, and of their friction per normal force
    for (const Vector2d& point : points_) {
      levers.push_back(turn * point);
      const Vector2d v = s.v + s.spin * Vector2d(-levers.back().y(), levers.back().x());
      along.push_back(v.norm() > 0 ? Vector2d(-friction_ * v / v.norm()) : Vector2d::Zero());
    }
    const Vector3d share = normal_shares(levers, along);
    Planar out{s.v, Vector2d::Zero(), s.spin, 0};
    for (std::size_t i = 0; i < levers.size(); ++i) {
      const Vector2d f = share.dot(Vector3d(1, levers[i].x(), levers[i].y())) * along[i];
      out.v += f / mass_.mass_kg;
      out.spin += (levers[i].x() * f.y() - levers[i].y() * f.x()) / mass_.inertia(2, 2);
    }
    return out;
  }
  /// Normal forces are share . (1, x, y), such that nothing lifts or tips.
  [[nodiscard]] Vector3d normal_shares(const std::vector<Vector2d>& levers,
                                       const std::vector<Vector2d>& along) const {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < levers.size(); ++i) {
      const Vector3d at(1, levers[i].x(), levers[i].y());
      A.row(0) += at;
      A.row(1) += (levers[i].x() + height_m_ * along[i].x()) * at;
      A.row(2) += (levers[i].y() + height_m_ * along[i].y()) * at;
    }
    return A.inverse() * Vector3d(mass_.mass_kg * kGravity, 0, 0);
  }

  std::vector<Vector2d> points_;
  double height_m_;
  physics::MassProperties mass_;
  double friction_;
};

/// The tray's points of touch from its centre of mass, in the world's directions.
std::vector<Vector2d> touch(const Bench& bench, const Vector3d& com) {
  std::vector<api::ContactSnapshot> contacts;
  bench.world->write_contacts(contacts);
  std::vector<Vector2d> out;
  for (const auto& contact : contacts) out.push_back((contact.p_W - com).head<2>());
  if (out.size() < 3) throw std::runtime_error("the tray does not lie on the plate");
  return out;
}

}  // namespace

SpinResult slide_and_spin(const SpinCase& c) {
  Bench bench(scene_of(c));
  const auto mass = physics::tray_mass(bench.scene.tray_types.at(kTray));
  const auto com = [&] { return Vector3d(bench.X_WB("tray") * mass.com); };
  bench.run(static_cast<int>(std::lround(kSettled / c.step_s)));
  const Vector3d start = com();
  const Vector2d v(c.speed_m_s * std::cos(c.heading_rad), c.speed_m_s * std::sin(c.heading_rad));
  const SlidingBody reference(touch(bench, start), start.z(), mass, c.friction);
  const Planar struck{.v = v, .spin = c.spin_rad_s};
  Planar begin = reference.after(struck, 0.5 * c.step_s);
  begin.p.setZero();
  begin.yaw = 0;
  const Planar rest = reference.rest_from(begin), later = reference.rest_from(struck);

  bench.world->set_velocity(0, {v.x(), v.y(), 0}, {0, 0, c.spin_rad_s});
  Planar simulated;
  for (long left = std::lround(kMost / c.step_s); left > 0; --left) {
    const double heading = bench.X_WB("tray").linear().col(0).head<2>().norm();
    if (heading < 0.9) throw std::runtime_error("the tray has tipped");
    const Eigen::Matrix3d before = bench.X_WB("tray").linear();
    bench.run(1);
    const Eigen::Matrix3d turn = bench.X_WB("tray").linear() * before.transpose();
    simulated.yaw += std::atan2(turn(1, 0), turn(0, 0));
    const auto state = bench.world->body(0);
    if (state.v_W.norm() < 1e-6 && state.omega_W.norm() < 1e-5) break;
  }
  simulated.p = (com() - start).head<2>();
  SpinResult result{.way_m = simulated.p.norm(),
                    .yaw_rad = simulated.yaw,
                    .true_way_m = rest.p.norm(),
                    .true_yaw_rad = rest.yaw};
  result.way_error = (simulated.p - rest.p).norm() / rest.p.norm();
  result.yaw_error = std::abs(simulated.yaw / rest.yaw - 1);
  result.later_way_error = (simulated.p - later.p).norm() / later.p.norm();
  result.later_yaw_error = std::abs(simulated.yaw / later.yaw - 1);
  return result;
}

SpinCase random_spin(std::mt19937_64& engine) {
  std::uniform_real_distribution<double> unit(0, 1);
  constexpr double kTurn = 2 * std::numbers::pi;
  SpinCase out;
  out.friction = 0.15 + 0.35 * unit(engine);
  out.speed_m_s = 0.3 + 0.7 * unit(engine);
  out.heading_rad = kTurn * unit(engine);
  out.spin_rad_s = (unit(engine) < 0.5 ? -1 : 1) * (3 + 9 * unit(engine));
  out.tray_yaw_rad = kTurn * unit(engine);
  return out;
}

}  // namespace aprsim::bench
