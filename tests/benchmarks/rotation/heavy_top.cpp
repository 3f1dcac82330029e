#include "tests/benchmarks/rotation/heavy_top.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/unit/world/physics/cell_builder.hpp"
#include "world/physics/bodies/mass_properties.hpp"

namespace aprsim::bench {
namespace {

using Eigen::Vector3d;

constexpr double kGravity = 9.81;
constexpr int kFineSteps = 20;  // of the integration in a step of the simulation
constexpr double kLast = 1;     // [s] at the end, in which tilts are compared
/// Resting bodies keep this depth [m]. A top that begins above it would nod by its fall.
constexpr double kDepth = 2e-6;

/// Least and greatest of some tilts.
struct Range {
  double least = 1e9, most = 0;
  void add(double tilt) {
    least = std::min(least, tilt);
    most = std::max(most, tilt);
  }
};

scene::GearType type_of(const Top& top) {
  scene::GearType type;
  type.name = "top";
  type.disc_radius_m = top.disc_radius_m;
  type.disc_height_m = type.peg_top_m = top.disc_height_m;
  type.hub_top_radius_m = 0.1 * top.disc_radius_m;
  type.hub_height_m = top.point_m;
  type.mass_kg = top.mass_kg;
  return type;
}

/// Tilt, its rate and precession of a symmetric top (Goldstein, Classical Mechanics, 5.7), whose
/// point stays or slides without friction.
class SymmetricTop {
 public:
  struct State {
    double tilt = 0, rate = 0, precession = 0;
  };

  SymmetricTop(const physics::MassProperties& mass, double point_m, bool sliding)
      : mass_kg_(mass.mass_kg),
        lever_m_(mass.com.z() + point_m),
        i3_(mass.inertia(2, 2)),
        i1_(mass.inertia(0, 0) + (sliding ? 0 : mass_kg_ * lever_m_ * lever_m_)),
        sliding_(sliding) {}

  [[nodiscard]] double lever_m() const { return lever_m_; }
  /// Rate of the slow regular precession at a tilt, by its spin about the axis.
  [[nodiscard]] double steady_precession(double tilt, double spin) const {
    const double a = i1_ * std::cos(tilt), b = i3_ * spin, c = mass_kg_ * kGravity * lever_m_;
    return 2 * c / (b + std::sqrt(b * b - 4 * a * c));
  }
  void start(double tilt, double precession_rate, double spin) {
    state_ = {tilt, 0, 0};
    spin_ = spin;
    about_vertical_ =
        i1_ * precession_rate * std::pow(std::sin(tilt), 2) + i3_ * spin * std::cos(tilt);
  }
  /// A step with the method of Runge and Kutta.
  void advance(double h) {
    const State k1 = rate(state_), k2 = rate(after(k1, 0.5 * h)), k3 = rate(after(k2, 0.5 * h)),
                k4 = rate(after(k3, h));
    state_ = after({(k1.tilt + 2 * k2.tilt + 2 * k3.tilt + k4.tilt) / 6,
                    (k1.rate + 2 * k2.rate + 2 * k3.rate + k4.rate) / 6,
                    (k1.precession + 2 * k2.precession + 2 * k3.precession + k4.precession) / 6},
                   h);
  }
  [[nodiscard]] const State& state() const { return state_; }

 private:
  [[nodiscard]] State after(const State& rate, double h) const {
    return {state_.tilt + h * rate.tilt, state_.rate + h * rate.rate,
            state_.precession + h * rate.precession};
  }
  [[nodiscard]] State rate(const State& s) const {
    const double sine = std::sin(s.tilt), cosine = std::cos(s.tilt);
    const double weight = mass_kg_ * kGravity * lever_m_;
    const double turn = (about_vertical_ - i3_ * spin_ * cosine) / (i1_ * sine * sine);
    double torque = i1_ * turn * turn * sine * cosine - i3_ * spin_ * turn * sine + weight * sine;
    double inertia = i1_;
    if (sliding_) {
      const double orbit = mass_kg_ * lever_m_ * lever_m_;
      torque -= orbit * sine * cosine * s.rate * s.rate;
      inertia += orbit * sine * sine;
    }
    return {s.rate, torque / inertia, turn};
  }

  double mass_kg_, lever_m_, i3_, i1_;
  bool sliding_;
  double spin_ = 0, about_vertical_ = 0;
  State state_;
};

/// The top upon its point at the origin.
scene::Scene scene_of(const Top& top, const Eigen::Quaterniond& q) {
  scene::Scene scene = physics::test::empty_scene();
  scene.physics.simplification = top.mode;
  scene.physics.step_s = top.step_s;
  scene.physics.friction.gear_ground = top.friction;
  physics::test::add_table(scene);
  scene.gear_types["top"] = type_of(top);
  Pose pose;
  pose.q = q;
  pose.p = q * Vector3d(0, 0, top.point_m) - Vector3d(0, 0, kDepth);
  physics::test::add_gear(scene, "top", "top", pose);
  return scene;
}

}  // namespace

Top random_top(std::mt19937_64& engine) {
  std::uniform_real_distribution<double> unit(0, 1);
  const auto between = [&](double low, double high) { return low + (high - low) * unit(engine); };
  Top top;
  top.disc_radius_m = between(0.03, 0.05);
  top.disc_height_m = between(0.004, 0.01);
  top.point_m = between(0.015, 0.03);
  top.mass_kg = between(0.02, 0.1);
  // The disc stays clear of the table.
  top.tilt_rad = between(0.1, 0.6 * std::atan(top.point_m / top.disc_radius_m));
  top.spin_rad_s = (unit(engine) < 0.5 ? -1 : 1) * between(100, 200);
  top.heading_rad = between(0, 2 * std::numbers::pi);
  return top;
}

TopErrors spin(const Top& top, double seconds) {
  const physics::MassProperties mass = physics::gear_mass(type_of(top));
  SymmetricTop reference(mass, top.point_m, top.friction == 0);
  const double steady = top.spin_rad_s > 0
                            ? reference.steady_precession(top.tilt_rad, top.spin_rad_s)
                            : -reference.steady_precession(top.tilt_rad, -top.spin_rad_s);
  const double precession = top.steady ? steady : 0;
  reference.start(top.tilt_rad, precession, top.spin_rad_s);

  const Eigen::Quaterniond q = Eigen::AngleAxisd(top.heading_rad, Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(top.tilt_rad, Vector3d::UnitY());
  physics::test::Bench bench(scene_of(top, q));
  const Vector3d axis = q * Vector3d::UnitZ();
  const Vector3d omega =
      precession * (Vector3d::UnitZ() - std::cos(top.tilt_rad) * axis) + top.spin_rad_s * axis;
  const Vector3d v =
      top.friction == 0 ? Vector3d::Zero() : Vector3d(omega.cross(reference.lever_m() * axis));
  bench.world->set_velocity(0, v, omega);

  TopErrors out;
  double way = 0;
  Range integrated, simulated;
  Vector3d before = axis;
  for (long left = std::lround(seconds / top.step_s); left > 0; --left) {
    bench.run(1);
    for (int i = 0; i < kFineSteps; ++i) reference.advance(top.step_s / kFineSteps);
    const Eigen::Isometry3d X = bench.X_WB("top");
    const Vector3d now = X.linear().col(2);
    way += std::atan2(before.x() * now.y() - before.y() * now.x(),
                      before.head<2>().dot(now.head<2>()));
    before = now;
    const double tilt = std::atan2(now.head<2>().norm(), now.z());
    if (static_cast<double>(left) * top.step_s <= kLast) {
      integrated.add(reference.state().tilt);
      simulated.add(tilt);
    }
    out.point_m = std::max(out.point_m, (X * Vector3d(0, 0, -top.point_m)).norm());
  }
  out.tilt_rad = reference.state().tilt;
  out.precession_rad = reference.state().precession;
  out.tilt = std::max(std::abs(simulated.least - integrated.least),
                      std::abs(simulated.most - integrated.most)) /
             integrated.most;
  out.precession = std::abs(way / out.precession_rad - 1);
  return out;
}

}  // namespace aprsim::bench
