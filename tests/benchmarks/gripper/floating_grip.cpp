#include "tests/benchmarks/gripper/floating_grip.hpp"

#include <algorithm>
#include <cmath>

#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::bench {
namespace {

using physics::test::Bench;

constexpr double kAboveDisc = 3.5e-3,
                 kLift = 0.25;     // the longest way of a shake is 0.15 m
constexpr double kDropped = 0.01;  // [m] in the hand

scene::Scene scene_of(const ShakeCase& c) {
  scene::Scene scene = physics::test::empty_scene();
  scene.physics.step_s = c.step_s;
  scene.physics.engine = c.engine;
  scene.physics.ode = c.ode;
  physics::test::add_table(scene);
  const scene::GearType& gear = scene.gear_types.at(c.gear);
  Pose pose;
  pose.p.z() = gear.hub_height_m;
  physics::test::add_gear(scene, "g", c.gear, pose);
  const double tip = gear.hub_height_m + gear.disc_height_m + kAboveDisc;
  scene::Gripper& gripper = physics::test::add_hand(scene, {0, 0, tip}).gripper;
  gripper.law = c.law.law;
  gripper.pad = c.law.pad;
  gripper.force_n = c.force_n;
  gripper.pad_friction = c.pad_friction;
  if (!c.law.integral_and_derivative) gripper.mimic.i_n_ms = gripper.mimic.d_ns_m = 0;
  return scene;
}

}  // namespace

Shake shake(const ShakeCase& c) {
  Bench hand(scene_of(c));
  hand.run(50);
  hand.grip(0);
  const Eigen::Vector3d gripped_T = hand.X_TB("g").translation();
  hand.move({0, 0, kLift}, 0.5);
  hand.run(50);
  Shake result;
  // Its place decides: an iterative engine may chatter so that no sensor would call it held.
  result.held_at_start = (hand.X_TB("g").translation() - gripped_T).norm() < kDropped;
  if (!result.held_at_start) {
    result.dropped = true;
    result.delta_m = kDropped;
    return result;
  }
  const Eigen::Isometry3d X_TG = hand.X_TB("g"), start = hand.X_WT;
  const Eigen::Vector3d a = start.linear() * c.direction_T.normalized() * c.accel_m_s2;
  const auto steps = std::lround(c.duration_s / c.step_s);
  for (long i = 1; i <= steps; ++i) {
    const double t = static_cast<double>(i) * c.step_s;
    Eigen::Isometry3d next = start;
    next.translation() += 0.5 * t * t * a;
    hand.step_tool(next);
    const Eigen::Isometry3d now = hand.X_TB("g");
    const double delta = (now.translation() - X_TG.translation()).norm();
    const double theta = physics::test::angle_between(X_TG, now);
    result.delta_over_time_m.push_back(delta);
    result.theta_over_time_rad.push_back(theta);
    result.delta_m = std::max(result.delta_m, delta);
    result.theta_rad = std::max(result.theta_rad, theta);
  }
  result.dropped = result.delta_m > kDropped;
  return result;
}

double drop_limit_up(const ShakeCase& c) {
  const scene::Scene scene = scene_of(c);
  // The two faces of a V press harder than the finger pushes: each by half of F / sin.
  const double wedge =
      c.law.pad == scene::PadShape::kV ? std::sin(scene.robots[0].gripper.v_half_angle_rad) : 1;
  return 2 * c.pad_friction * c.force_n / wedge / scene.gear_types.at(c.gear).mass_kg -
         scene.physics.gravity_m_s2;
}

}  // namespace aprsim::bench
