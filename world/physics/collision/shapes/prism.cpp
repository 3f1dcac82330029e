#include "world/physics/collision/shapes/prism.hpp"

#include <algorithm>

#include "world/scene/model/part_shapes.hpp"

namespace aprsim::physics::detail {

using Eigen::Vector2d;
using Eigen::Vector3d;

void Prism::set_sides(std::span<const Vector2d> corners, std::span<const Vector2d> normals) {
  sides = static_cast<int>(corners.size());
  std::copy(corners.begin(), corners.end(), v.begin());
  std::copy(normals.begin(), normals.end(), n.begin());
  for (std::size_t i = 0; i < corners.size(); ++i) off[i] = n[i].dot(v[i]);
}

Prism box_prism(const Vector3d& lo, const Vector3d& hi) {
  Prism prism;
  prism.sides = 4;
  prism.v[0] = {lo.x(), lo.y()};
  prism.v[1] = {hi.x(), lo.y()};
  prism.v[2] = {hi.x(), hi.y()};
  prism.v[3] = {lo.x(), hi.y()};
  prism.n[0] = {0, -1};
  prism.n[1] = {1, 0};
  prism.n[2] = {0, 1};
  prism.n[3] = {-1, 0};
  prism.off[0] = -lo.y();
  prism.off[1] = hi.x();
  prism.off[2] = hi.y();
  prism.off[3] = -lo.x();
  prism.z0 = lo.z();
  prism.z1 = hi.z();
  prism.middle = 0.5 * (lo + hi);
  return prism;
}

Prism slab_prism(const scene::TrayType& tray) {
  const Eigen::AlignedBox3d box = scene::slab_of(tray);
  if (!tray.outline) return box_prism(box.min(), box.max());
  Prism prism;
  prism.set_sides(tray.outline->corners, tray.outline->normals);
  prism.z0 = box.min().z();
  prism.z1 = box.max().z();
  // The mean of the corners of a convex polygon is inside.
  Vector2d sum = Vector2d::Zero();
  for (const Vector2d& corner : tray.outline->corners) sum += corner;
  prism.middle << sum / prism.sides, 0.5 * (prism.z0 + prism.z1);
  return prism;
}

}  // namespace aprsim::physics::detail
