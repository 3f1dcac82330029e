#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Geometry>

namespace aprsim::robot {

/// A tree of boxes for the question which of them are near a point. Thread: any, after building.
class ObstacleTree {
 public:
  explicit ObstacleTree(std::vector<Eigen::AlignedBox3d> boxes);

  /// Calls `visit(index)` for each box within `distance_m` of the point, in a fixed order, until it
  /// returns false. Returns whether it never did.
  template <typename Visit>
  bool near(const Eigen::Vector3d& point, double distance_m, Visit&& visit) const {
    if (nodes_.empty()) return true;
    const double square = distance_m * distance_m;
    std::array<std::size_t, kMostDepth> stack{};
    std::size_t size = 1;
    while (size > 0) {
      const Node& node = nodes_[stack[--size]];
      if (node.box.squaredExteriorDistance(point) > square) continue;
      if (node.right != 0) {
        stack[size++] = node.right;
        stack[size++] = node.left;
        continue;
      }
      for (std::size_t i = node.first; i < node.last; ++i) {
        const std::size_t index = order_[i];
        if (boxes_[index].squaredExteriorDistance(point) > square) continue;
        if (!visit(index)) return false;
      }
    }
    return true;
  }

 private:
  static constexpr std::size_t kMostDepth = 64, kLeaf = 4;
  struct Node {
    Eigen::AlignedBox3d box;
    std::size_t left = 0, right = 0;  ///< right 0: a leaf
    std::size_t first = 0, last = 0;
  };
  std::size_t build(std::size_t first, std::size_t last);

  std::vector<Eigen::AlignedBox3d> boxes_;
  std::vector<std::size_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace aprsim::robot
