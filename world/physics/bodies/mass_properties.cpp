#include "world/physics/bodies/mass_properties.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "world/physics/collision/shapes/gear_shape.hpp"
#include "world/physics/collision/shapes/pocket.hpp"
#include "world/physics/collision/shapes/pocket_outline.hpp"
#include "world/scene/model/part_shapes.hpp"

namespace aprsim::physics {
namespace {

/// Volume, first moment and second moments (integral of x x^T) about the frame's origin.
struct Moments {
  double volume = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();

  void add(const Moments& m, double sign) {
    volume += sign * m.volume;
    first += sign * m.first;
    second += sign * m.second;
  }
};

// Gauss-Legendre nodes and weights (Abramowitz & Stegun 1964, table 25.4).
const std::array<double, 3> kGaussNode{-std::sqrt(0.6), 0, std::sqrt(0.6)};
constexpr std::array<double, 3> kGaussWeight{5.0 / 9, 8.0 / 9, 5.0 / 9};

/// Frustum about the line x = xy parallel to z. Three-point Gauss quadrature is exact here: every
/// integrand is a polynomial in z of degree 4 or less.
Moments frustum(double z0, double r0, double z1, double r1, const Eigen::Vector2d& xy) {
  Moments m;
  for (std::size_t i = 0; i < 3; ++i) {
    const double t = 0.5 * (1 + kGaussNode[i]);
    const double z = z0 + (z1 - z0) * t, r = r0 + (r1 - r0) * t;
    const double dv = 0.5 * kGaussWeight[i] * (z1 - z0) * std::numbers::pi * r * r;
    const Eigen::Vector3d c(xy.x(), xy.y(), z);
    m.volume += dv;
    m.first += dv * c;
    m.second += dv * (c * c.transpose());
    // Second moment of a disc about its diameter: r^2 / 4 per volume.
    m.second(0, 0) += dv * r * r / 4;
    m.second(1, 1) += dv * r * r / 4;
  }
  return m;
}

/// Between two corners.
Moments box(const Eigen::Vector3d& lo, const Eigen::Vector3d& hi) {
  const Eigen::Vector3d size = hi - lo, c = 0.5 * (lo + hi);
  Moments m;
  m.volume = size.prod();
  m.first = m.volume * c;
  m.second = m.volume * (c * c.transpose());
  // Second moment of an interval of length l about its middle: l^2 / 12.
  m.second.diagonal() += m.volume / 12 * size.cwiseAbs2();
  return m;
}

/// Prism between two heights, by Green's theorem over its sides.
Moments prism(const std::vector<Eigen::Vector2d>& corners, double z0, double z1) {
  double area = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d &a = corners[i], &b = corners[(i + 1) % corners.size()];
    const double cross = a.x() * b.y() - a.y() * b.x();
    area += cross / 2;
    x += cross * (a.x() + b.x()) / 6;
    y += cross * (a.y() + b.y()) / 6;
    xx += cross * (a.x() * a.x() + a.x() * b.x() + b.x() * b.x()) / 12;
    yy += cross * (a.y() * a.y() + a.y() * b.y() + b.y() * b.y()) / 12;
    xy += cross * (a.x() * b.y() + 2 * (a.x() * a.y() + b.x() * b.y()) + b.x() * a.y()) / 24;
  }
  const double height = z1 - z0, z = (z1 * z1 - z0 * z0) / 2;
  const double zz = (z1 * z1 * z1 - z0 * z0 * z0) / 3;
  Moments m;
  m.volume = area * height;
  m.first = {x * height, y * height, area * z};
  m.second << xx * height, xy * height, x * z, xy * height, yy * height, y * z, x * z, y * z,
      area * zz;
  return m;
}

/// Takes a pocket with an outline away. The chamfer widens linearly: Gauss quadrature over z is
/// exact, as for a frustum.
void subtract_outline(const scene::Slot& slot, Moments& total) {
  const detail::PocketOutline p(slot);
  const auto at = [&p](double by) {
    std::vector<Eigen::Vector2d> corners;
    for (std::size_t i = 0; i < p.sides; ++i) corners.push_back(p.corner(i, by));
    return corners;
  };
  total.add(prism(at(0), -p.depth, p.z_edge), -1);
  if (!p.chamfered()) return;
  for (std::size_t i = 0; i < kGaussNode.size(); ++i) {
    const double t = 0.5 * (1 + kGaussNode[i]), z = p.z_edge * (1 - t);
    const double dz = 0.5 * kGaussWeight[i] * -p.z_edge;
    // A layer at one height, without its own thickness.
    Moments layer = prism(at(p.width * t), z - 0.5 * dz, z + 0.5 * dz);
    layer.second(2, 2) = layer.volume * z * z;
    total.add(layer, -1);
  }
}

/// Steiner's theorem back to the centre of mass, and from second moments to inertia: I = tr(S) 1 -
/// S.
MassProperties with_mass(const Moments& m, double mass_kg) {
  MassProperties result;
  result.mass_kg = mass_kg;
  if (!(m.volume > 0)) return result;
  const double density = mass_kg / m.volume;
  result.com = m.first / m.volume;
  const Eigen::Matrix3d central =
      density * (m.second - m.volume * (result.com * result.com.transpose()));
  result.inertia = central.trace() * Eigen::Matrix3d::Identity() - central;
  return result;
}

}  // namespace

MassProperties gear_mass(const scene::GearType& gear) {
  const detail::GearShape shape = gear;
  Moments total;
  for (int i = 0; i < shape.piece_count; ++i) {
    const detail::Piece& p = shape.pieces[static_cast<std::size_t>(i)];
    total.add(frustum(p.z0, p.r0, p.z1, p.r1, Eigen::Vector2d::Zero()), 1);
  }
  return with_mass(total, gear.mass_kg);
}

MassProperties tray_mass(const scene::TrayType& tray) {
  // The slab, less the label's recess, a frustum for each pocket's wall and one for its chamfer.
  const Eigen::AlignedBox3d slab = scene::slab_of(tray);
  Moments total = tray.outline ? prism(tray.outline->corners, slab.min().z(), slab.max().z())
                               : box(slab.min(), slab.max());
  if (tray.label) {
    const double half = tray.label->size_m / 2;
    total.add(box({-half, -half, -tray.label->depth_m}, {half, half, 0}), -1);
  }
  for (const scene::Slot& slot : tray.slots) {
    if (slot.pocket.outline) {
      subtract_outline(slot, total);
      continue;
    }
    const detail::PocketProfile p(slot);
    total.add(frustum(-p.depth, p.r_floor, p.z_edge, p.r_edge, slot.xy), -1);
    total.add(frustum(p.z_edge, p.r_edge, 0, p.r_mouth, slot.xy), -1);
  }
  return with_mass(total, tray.mass_kg);
}

MassProperties tool_mass(const scene::Gripper& gripper) {
  const scene::Block palm = scene::palm_of(gripper);
  const double kg = gripper.mount_mass_kg + gripper.palm_mass_kg + 2 * gripper.finger_mass_kg;
  return with_mass(box(palm.centre - 0.5 * palm.size, palm.centre + 0.5 * palm.size), kg);
}

Eigen::Matrix3d box_inertia(double mass_kg, const Eigen::Vector3d& size_m) {
  const Eigen::Vector3d squared = size_m.cwiseAbs2();
  const Eigen::Vector3d sums(squared.y() + squared.z(), squared.x() + squared.z(),
                             squared.x() + squared.y());
  return (mass_kg / 12 * sums).asDiagonal();
}

MassProperties combined(const MassProperties& a, const MassProperties& b,
                        const Eigen::Isometry3d& X_AB) {
  MassProperties total;
  total.mass_kg = a.mass_kg + b.mass_kg;
  const Eigen::Vector3d com_b = X_AB * b.com;
  total.com = (a.mass_kg * a.com + b.mass_kg * com_b) / total.mass_kg;
  // Steiner's theorem (parallel axes), products of inertia included.
  const auto moved = [&total](double kg, const Eigen::Vector3d& com) {
    const Eigen::Vector3d r = com - total.com;
    return (kg * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose())).eval();
  };
  const Eigen::Matrix3d R = X_AB.linear();
  total.inertia =
      a.inertia + moved(a.mass_kg, a.com) + R * b.inertia * R.transpose() + moved(b.mass_kg, com_b);
  return total;
}

}  // namespace aprsim::physics
