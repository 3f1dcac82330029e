#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Geometry>

#include "world/api/values/piece.hpp"
#include "world/physics/collision/shapes/prism.hpp"

namespace aprsim::physics::detail {

/// A convex polyhedron as its corners, faces and edges.
struct Polytope {
  static constexpr std::size_t kMaxCorners = 64, kMaxFaces = 2 * kMaxCorners - 4;

  struct Face {
    Eigen::Vector3d n;         ///< outward
    double off = 0;            ///< n . p on it
    int first = 0, count = 0;  ///< its corners in `loops`, counter-clockwise seen from outside
    bool internal = false;     ///< towards another part of the same body: nothing leaves there
  };
  struct Edge {
    int from = 0, to = 0;        ///< corners
    int left = 0, right = 0;     ///< faces beside it, seen from outside
    int before = 0, beyond = 0;  ///< another face at each end
  };
  std::vector<Eigen::Vector3d> corners;
  std::vector<Face> faces;
  std::vector<Edge> edges;
  std::vector<int> loops;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  ///< a point well inside

  [[nodiscard]] const Eigen::Vector3d& corner(int i) const {
    return corners[static_cast<std::size_t>(i)];
  }
  [[nodiscard]] const Face& face(int i) const { return faces[static_cast<std::size_t>(i)]; }
  /// Corner number k of a face, counted around it.
  [[nodiscard]] int loop_corner(const Face& face, int k) const {
    return loops[static_cast<std::size_t>(face.first + k % face.count)];
  }

  /// Becomes a prism: side i is face i, then the bottom and the top. Does not allocate once it has
  /// been as large.
  void set_prism(const Prism& prism);
  void set_hull(const api::HullPiece& hull);

 private:
  [[nodiscard]] int third_face(int corner, const Edge& edge) const;
};

}  // namespace aprsim::physics::detail
