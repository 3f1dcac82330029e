#include "world/robot/avoidance/obstacle_tree.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace aprsim::robot {

ObstacleTree::ObstacleTree(std::vector<Eigen::AlignedBox3d> boxes) : boxes_(std::move(boxes)) {
  order_.resize(boxes_.size());
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  if (!boxes_.empty()) build(0, boxes_.size());
}

std::size_t ObstacleTree::build(std::size_t first, std::size_t last) {
  const std::size_t index = nodes_.size();
  nodes_.emplace_back();
  Eigen::AlignedBox3d box;
  for (std::size_t i = first; i < last; ++i) box.extend(boxes_[order_[i]]);
  nodes_[index].box = box;
  nodes_[index].first = first;
  nodes_[index].last = last;
  if (last - first <= kLeaf) return index;
  // Halves along the widest direction; equal centres keep their order.
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const auto begin = order_.begin();
  std::stable_sort(begin + static_cast<std::ptrdiff_t>(first),
                   begin + static_cast<std::ptrdiff_t>(last), [&](std::size_t a, std::size_t b) {
                     return boxes_[a].center()(axis) < boxes_[b].center()(axis);
                   });
  const std::size_t middle = first + (last - first) / 2;
  const std::size_t left = build(first, middle);
  const std::size_t right = build(middle, last);
  nodes_[index].left = left;
  nodes_[index].right = right;
  return index;
}

}  // namespace aprsim::robot
