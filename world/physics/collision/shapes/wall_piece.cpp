#include "world/physics/collision/shapes/wall_piece.hpp"

#include <array>
#include <span>

namespace aprsim::physics::detail {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kThick = 2e-3;      // of a wall's piece [m]
constexpr double kUnderWall = 5e-4;  // of a floor's piece [m]

void add_face(Polytope& piece, std::initializer_list<int> loop, bool internal) {
  Polytope::Face face;
  face.first = static_cast<int>(piece.loops.size());
  face.count = static_cast<int>(loop.size());
  face.internal = internal;
  piece.loops.insert(piece.loops.end(), loop.begin(), loop.end());
  const auto at = [&](int k) -> const Vector3d& {
    return piece.corner(piece.loop_corner(face, k));
  };
  face.n = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
  face.off = face.n.dot(at(0));
  piece.faces.push_back(face);
}

}  // namespace

void set_wall_piece(const PocketOutline& pocket, std::size_t side, double underside,
                    Polytope& piece) {
  piece.corners.clear();
  piece.faces.clear();
  piece.edges.clear();
  piece.loops.clear();
  // The same profile at both corners: from below up the wall, over the chamfer, outwards, and down.
  struct Point {
    double by, z;
  };
  const double outer = pocket.width + kThick;
  const std::array<Point, 5> profile{
      {{0, underside}, {0, pocket.z_edge}, {pocket.width, 0}, {outer, 0}, {outer, underside}}};
  const int skipped = pocket.chamfered() ? -1 : 2, count = pocket.chamfered() ? 5 : 4;
  for (const std::size_t corner : {side, pocket.next(side)}) {
    for (int k = 0; k < static_cast<int>(profile.size()); ++k) {
      if (k == skipped) continue;
      const Point& point = profile[static_cast<std::size_t>(k)];
      const Vector2d p = pocket.corner(corner, point.by);
      piece.corners.emplace_back(p.x(), p.y(), point.z);
    }
  }
  // Corner k of the profile is corner k at the side's begin and corner count + k at its end.
  for (int k = 0; k < count; ++k) {
    const int up = (k + 1) % count;
    const bool internal = k >= count - 2;  // outer face and underside
    add_face(piece, {count + k, k, up, count + up}, internal);
  }
  if (count == 5) {
    add_face(piece, {4, 3, 2, 1, 0}, true);
    add_face(piece, {5, 6, 7, 8, 9}, true);
  } else {
    add_face(piece, {3, 2, 1, 0}, true);
    add_face(piece, {4, 5, 6, 7}, true);
  }
  for (int k = 1; k + 2 < count; ++k) {
    piece.edges.push_back({k, count + k, k - 1, k, count, count + 1});
  }
  piece.middle.setZero();
  for (const Vector3d& corner : piece.corners) {
    piece.middle += corner / static_cast<double>(piece.corners.size());
  }
}

void set_floor_piece(const PocketOutline& pocket, double underside, Prism& piece) {
  std::array<Vector2d, PocketOutline::kMost> corners;
  for (std::size_t i = 0; i < pocket.sides; ++i) corners[i] = pocket.corner(i, kUnderWall);
  piece.set_sides(std::span(corners).first(pocket.sides),
                  std::span(pocket.normals).first(pocket.sides));
  piece.internal.fill(true);
  piece.z0 = underside;
  piece.z1 = -pocket.depth;
  piece.middle = {pocket.middle.x(), pocket.middle.y(), 0.5 * (underside - pocket.depth)};
}

}  // namespace aprsim::physics::detail
