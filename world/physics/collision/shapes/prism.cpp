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
  const std::array<Vector2d, 4> corners{Vector2d(lo.x(), lo.y()), Vector2d(hi.x(), lo.y()),
                                        Vector2d(hi.x(), hi.y()), Vector2d(lo.x(), hi.y())};
  const std::array<Vector2d, 4> normals{Vector2d(0, -1), Vector2d(1, 0), Vector2d(0, 1),
                                        Vector2d(-1, 0)};
  Prism prism;
  prism.set_sides(corners, normals);
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
