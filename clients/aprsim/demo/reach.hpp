#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "clients/aprsim/demo/cell_view.hpp"

namespace aprsim::client {

/// A place that a robot has refused to go to.
struct Refusal {
  SlotView place;
  bool too_far = false;  ///< not for another reason, such as a joint's limit
};

/// What a robot has been found not to reach. It turns about its base: what lies farther out at the
/// height of a place that is too far is too far as well.
class Reach {
 public:
  explicit Reach(const Eigen::Vector3d& p_WB) : p_WB_(p_WB) {}

  void exclude(const Refusal& refusal) { refusals_.push_back(refusal); }
  [[nodiscard]] bool excludes(const SlotView& place) const;

 private:
  [[nodiscard]] double distance(const SlotView& place) const;

  Eigen::Vector3d p_WB_;
  std::vector<Refusal> refusals_;
};

}  // namespace aprsim::client
