#include "tests/unit/world/physics/collision/solids.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/gear_types.hpp"

namespace aprsim::physics::test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Closed polygon in (r, z); the part on the axis r = 0 is no boundary.
using Profile = std::vector<Vector2d>;

double segment_distance(const Vector2d& a, const Vector2d& b, const Vector2d& p) {
  const Vector2d d = b - a;
  const double t = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
  return (a + t * d - p).norm();
}

double profile_distance(const Profile& profile, const Vector2d& p) {
  bool inside = false;
  double distance = 1e30;
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const Vector2d &a = profile[i], &b = profile[(i + 1) % profile.size()];
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) {
      inside = !inside;
    }
    if (a.x() == 0 && b.x() == 0) continue;
    distance = std::min(distance, segment_distance(a, b, p));
  }
  return inside ? -distance : distance;
}

Profile gear_profile(const scene::GearType& g) {
  const double slope = (g.hub_top_radius_m - g.hub_bottom_radius_m) / g.hub_height_m;
  const double edge = g.hub_bottom_radius_m + slope * g.hub_chamfer_m;
  return {{0, -g.hub_height_m},
          {edge - g.hub_chamfer_m, -g.hub_height_m},
          {edge, g.hub_chamfer_m - g.hub_height_m + 1e-12},
          {g.hub_top_radius_m, 0},
          {g.disc_radius_m, 0},
          {g.disc_radius_m, g.disc_height_m},
          {g.peg_radius_m, g.disc_height_m},
          {g.peg_radius_m, g.peg_top_m},
          {0, g.peg_top_m}};
}

/// The void of a pocket, carried on above the top face as a cylinder.
Profile pocket_profile(const scene::Pocket& p) {
  const double slope = (p.top_radius_m - p.floor_radius_m) / p.depth_m;
  const double edge = p.top_radius_m - slope * p.chamfer_m;
  const double mouth = edge + p.chamfer_m * std::tan(p.chamfer_angle_rad);
  Profile profile{{0, -p.depth_m}, {p.floor_radius_m, -p.depth_m}, {edge, -p.chamfer_m}};
  if (p.chamfer_m > 0) profile.emplace_back(mouth, 0);
  profile.emplace_back(mouth, 0.1);
  profile.emplace_back(0, 0.1);
  return profile;
}

Vector3d around_axis(double r, double z, int i, int n) {
  const double a = 2 * std::numbers::pi * i / n;
  return {r * std::cos(a), r * std::sin(a), z};
}

void add_segment(std::vector<Vector3d>& out, const Vector3d& a, const Vector3d& b, int n) {
  for (int i = 0; i <= n; ++i) out.emplace_back(a + (b - a) * (static_cast<double>(i) / n));
}

void add_box_edges(std::vector<Vector3d>& out, const Vector3d& lo, const Vector3d& hi, int n) {
  const auto corner = [&](int k) {
    return Vector3d(k & 1 ? hi.x() : lo.x(), k & 2 ? hi.y() : lo.y(), k & 4 ? hi.z() : lo.z());
  };
  for (int k = 0; k < 8; ++k) {
    for (const int bit : {1, 2, 4}) {
      if (!(k & bit)) add_segment(out, corner(k), corner(k | bit), n);
    }
  }
}

scene::TrayType tray_of(const scene::Pocket& pocket) {
  scene::TrayType tray;
  tray.min_xy = {-0.08, -0.08};
  tray.max_xy = {0.08, 0.08};
  tray.thickness_m = 0.015;
  tray.mass_kg = 0.2;
  for (const double x : {-0.045, 0.045}) {
    for (const double y : {-0.045, 0.045}) tray.slots.push_back({"", "", {x, y}, pocket});
  }
  return tray;
}

}  // namespace

scene::GearType conical_gear() {
  scene::GearType gear = gear_type("small");
  gear.hub_chamfer_m = 0;
  return gear;
}

scene::GearType cylindrical_gear() { return gear_type("d60"); }

scene::TrayType conical_tray() {
  scene::Pocket p;
  p.top_radius_m = 0.0222;
  p.floor_radius_m = 0.01498;
  p.depth_m = 0.0125;
  return tray_of(p);
}

scene::TrayType cylindrical_tray() {
  scene::Pocket p;
  p.top_radius_m = p.floor_radius_m = 0.0103;
  p.depth_m = 0.0065;
  p.chamfer_m = 0.001;
  return tray_of(p);
}

scene::TrayType wedge_tray() {
  scene::TrayType tray = conical_tray();
  tray.outline = scene::outline_of({{-0.08, -0.08},
                                    {0.06, -0.085},
                                    {0.085, -0.06},
                                    {0.09, 0.07},
                                    {0.06, 0.09},
                                    {-0.075, 0.08},
                                    {-0.085, 0}});
  tray.min_xy = {-0.085, -0.085};
  tray.max_xy = {0.09, 0.09};
  return tray;
}

std::vector<Vector2d> corners_of(const scene::TrayType& tray) {
  if (tray.outline) return tray.outline->corners;
  const Vector2d &lo = tray.min_xy, &hi = tray.max_xy;
  return {lo, {hi.x(), lo.y()}, hi, {lo.x(), hi.y()}};
}

double prism_distance(const std::vector<Vector2d>& corners, double z0, double z1,
                      const Vector3d& p) {
  bool inside = false;
  double beside = 1e30;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector2d &a = corners[i], &b = corners[(i + 1) % corners.size()];
    beside = std::min(beside, segment_distance(a, b, p.head<2>()));
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) {
      inside = !inside;
    }
  }
  const Vector2d q(inside ? -beside : beside, std::max(p.z() - z1, z0 - p.z()));
  return q.cwiseMax(0).norm() + std::min(0.0, q.maxCoeff());
}

double gear_distance(const scene::GearType& gear, const Vector3d& p) {
  return profile_distance(gear_profile(gear), {std::hypot(p.x(), p.y()), p.z()});
}

double box_distance(const Vector3d& half, const Vector3d& p) {
  const Vector3d q = p.cwiseAbs() - half;
  return q.cwiseMax(0).norm() + std::min(0.0, q.maxCoeff());
}

double tray_distance(const scene::TrayType& tray, const Vector3d& p) {
  double distance = prism_distance(corners_of(tray), -tray.thickness_m, 0, p);
  for (const scene::Slot& slot : tray.slots) {
    const Eigen::Vector2d d = p.head<2>() - slot.xy;
    const double into = -profile_distance(pocket_profile(slot.pocket), {d.norm(), p.z()});
    distance = std::max(distance, into);
  }
  return distance;
}

std::vector<Vector3d> gear_surface(const scene::GearType& gear, int around) {
  std::vector<Vector3d> points;
  const Profile profile = gear_profile(gear);
  for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
    constexpr int kSteps = 6;
    for (int s = 0; s < kSteps; ++s) {
      const Vector2d q = profile[k] + (profile[k + 1] - profile[k]) * (s / double{kSteps});
      for (int i = 0; i < around; ++i) points.push_back(around_axis(q.x(), q.y(), i, around));
    }
  }
  return points;
}

std::vector<Vector3d> gear_rims(const scene::GearType& gear, int around) {
  std::vector<Vector3d> points;
  for (const Vector2d& q : gear_profile(gear)) {
    if (q.x() == 0) continue;
    for (int i = 0; i < around; ++i) points.push_back(around_axis(q.x(), q.y(), i, around));
  }
  return points;
}

std::vector<Vector3d> tray_edges(const scene::TrayType& tray, int around) {
  std::vector<Vector3d> points;
  const std::vector<Vector2d> corners = corners_of(tray);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector2d &a = corners[i], &b = corners[(i + 1) % corners.size()];
    const double z = -tray.thickness_m;
    add_segment(points, {a.x(), a.y(), 0}, {b.x(), b.y(), 0}, around);
    add_segment(points, {a.x(), a.y(), z}, {b.x(), b.y(), z}, around);
    add_segment(points, {a.x(), a.y(), z}, {a.x(), a.y(), 0}, around);
  }
  for (const scene::Slot& slot : tray.slots) {
    const Profile profile = pocket_profile(slot.pocket);
    for (std::size_t k = 2; k + 2 < profile.size(); ++k) {
      for (int i = 0; i < around; ++i) {
        points.push_back(around_axis(profile[k].x(), profile[k].y(), i, around) +
                         Vector3d(slot.xy.x(), slot.xy.y(), 0));
      }
    }
  }
  return points;
}

std::vector<Vector3d> box_edges(const Vector3d& size, int along) {
  std::vector<Vector3d> points;
  add_box_edges(points, -0.5 * size, 0.5 * size, along);
  return points;
}

Eigen::Isometry3d pose(double x, double y, double z) {
  return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
}

Eigen::Isometry3d tilted(double x, double y, double z, double tilt, double heading) {
  const Vector3d axis(std::cos(heading), std::sin(heading), 0);
  return pose(x, y, z) * Eigen::AngleAxisd(tilt, axis);
}

double uniform(std::mt19937_64& random, double lo, double hi) {
  return lo + (hi - lo) * (static_cast<double>(random() >> 11) * 0x1p-53);
}

Eigen::Isometry3d random_rotation(std::mt19937_64& random) {
  Eigen::Vector4d q;
  do {
    for (int i = 0; i < 4; ++i) q[i] = uniform(random, -1, 1);
  } while (q.squaredNorm() > 1 || q.squaredNorm() < 0.01);
  q.normalize();
  return Eigen::Isometry3d(Eigen::Quaterniond(q[0], q[1], q[2], q[3]));
}

double deepest(const std::vector<Contact>& contacts) {
  double depth = 0;
  for (const Contact& c : contacts) depth = std::max(depth, c.depth_m);
  return depth;
}

}  // namespace aprsim::physics::test
