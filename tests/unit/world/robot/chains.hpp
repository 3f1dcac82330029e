#pragma once

#include <string>
#include <vector>

#include "tests/unit/world/robot/test_arms.hpp"

/// Arms that no maker has, each of a class for which no closed form is known or implemented.
namespace aprsim::robot::test {

inline Joint joint_of(const Eigen::Vector3d& axis, const Eigen::Vector3d& offset,
                      const Eigen::Vector3d& rpy, double lower, double upper, bool prismatic) {
  Joint out;
  out.prismatic = prismatic;
  out.axis = axis;
  out.X_PJ.translation() = offset;
  out.X_PJ.linear() = (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                       Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                       Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
                          .toRotationMatrix();
  out.lower_rad = lower;
  out.upper_rad = upper;
  out.max_speed_rad_s = prismatic ? 1 : 3;
  out.max_torque_nm = 200;
  return out;
}

/// Links of unequal bodies, and a flange beside the last axis.
inline ArmModel chain_of(const std::string& name, std::vector<Joint> joints) {
  ArmModel out;
  out.name = name;
  for (std::size_t i = 0; i <= joints.size(); ++i) {
    Link link;
    link.name = "link_" + std::to_string(i);
    link.mass_kg = 1 + 0.5 * static_cast<double>(i % 3);
    link.com_L << 0.02, -0.01, 0.03 + 0.01 * static_cast<double>(i);
    link.inertia_L << 4e-3, 2e-4, -1e-4, 2e-4, 5e-3, 3e-4, -1e-4, 3e-4, 6e-3;
    if (i > 0) joints[i - 1].name = "joint_" + std::to_string(i);
    out.links.push_back(link);
  }
  out.joints = std::move(joints);
  out.X_LF = Eigen::Isometry3d::Identity();
  out.X_LF->translation() << 0.01, 0.02, 0.05;
  out.X_LF->linear() = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 2) / 3).toRotationMatrix();
  return out;
}

inline Joint turning(const Eigen::Vector3d& axis, const Eigen::Vector3d& offset, double lower,
                     double upper, const Eigen::Vector3d& rpy = Eigen::Vector3d::Zero()) {
  return joint_of(axis, offset, rpy, lower, upper, false);
}

inline Joint sliding(const Eigen::Vector3d& axis, const Eigen::Vector3d& offset, double lower,
                     double upper) {
  return joint_of(axis, offset, Eigen::Vector3d::Zero(), lower, upper, true);
}

/// Six axes of which no three meet or are parallel.
inline ArmModel skew_six() {
  const auto x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
             z = Eigen::Vector3d::UnitZ();
  return chain_of(
      "skew_six",
      {turning(z, {0, 0, .3}, -2.8, 2.8, {0, 0, .1}), turning(y, {.05, 0, .1}, -2, 2, {.1, .05, 0}),
       turning(y, {0, .03, .4}, -2.4, 2.4, {0, .1, 0}),
       turning(x, {.1, 0, .05}, -3, 3, {.2, 0, .1}), turning(y, {.3, .02, 0}, -2, 2, {0, .1, .1}),
       turning(x, {.08, 0, .02}, -4, 4, {0, .2, 0})});
}

/// A base that turns, three parallel axes, a last one that turns the tool.
inline ArmModel five_axes() {
  const auto y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  return chain_of("five_axes", {turning(z, {0, 0, .3}, -2.8, 2.8), turning(y, {.05, 0, .1}, -2, 2),
                                turning(y, {0, 0, .3}, -2.4, 2.4), turning(y, {0, 0, .3}, -2, 2),
                                turning(z, {0, 0, .1}, -3, 3)});
}

/// A six-axis arm on a rail.
inline ArmModel rail_seven() {
  const auto x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
             z = Eigen::Vector3d::UnitZ();
  return chain_of("rail_seven", {sliding(x, {0, 0, .3}, -.5, 1), turning(z, {0, 0, .1}, -2.8, 2.8),
                                 turning(y, {.05, 0, .1}, -2, 2), turning(y, {0, 0, .4}, -2.4, 2.4),
                                 turning(x, {.1, 0, .05}, -3, 3), turning(y, {.3, 0, 0}, -2, 2),
                                 turning(x, {.08, 0, 0}, -4, 4)});
}

/// A gantry of three slides with a wrist.
inline ArmModel gantry_six() {
  const auto x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
             z = Eigen::Vector3d::UnitZ();
  return chain_of("gantry_six", {sliding(x, {0, 0, .3}, -.5, .5), sliding(y, {0, 0, .1}, -.4, .4),
                                 sliding(z, {0, 0, .1}, -.4, .4), turning(z, {0, 0, .1}, -3, 3),
                                 turning(y, {.05, 0, .1}, -2, 2), turning(x, {0, 0, .1}, -3, 3)});
}

/// Seven axes without a spherical shoulder.
inline ArmModel skew_seven() {
  const auto y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  return chain_of("skew_seven",
                  {turning(z, {0, 0, .3}, -2.8, 2.8), turning(y, {.05, .02, .1}, -2, 2),
                   turning(z, {0, .03, .2}, -2.4, 2.4),
                   turning(y, {.1, 0, .2}, -2.4, 0, {.1, 0, 0}), turning(z, {.1, 0, .2}, -2, 2),
                   turning(y, {0, .05, .1}, -2, 2), turning(z, {.08, 0, .06}, -3, 3)});
}

}  // namespace aprsim::robot::test
